"""A gate in Markdown: what failed and how to see it again, then the counts of each scheme."""

from collections import Counter
from collections.abc import Iterable, Iterator

from ...report.markdown import escaped
from ..gated import WORDS, Gated, shortened
from ..outcomes import ORDER, Outcome, Status
from .messages import estimate_text

# A step summary may hold 1 MiB; a row rarely takes more than 2 KiB.
MOST = 200


def markdown_report(gated: Gated) -> str:
    """Return the contents of ``gate.md``.

    Parameters
    ----------
    gated : Gated

    Returns
    -------
    str
        Names and texts of plugins stay in their cells and are shown as they are.
    """
    sign = "❌" if gated.code else "✅"
    lines = [
        f"## {sign} sdaeverify gate: {escaped(gated.words)}",
        "",
        f"{gated.summary}.",
        "",
        f"{gated.budget}.",
        "",
    ]
    lines += _listed("Lock file", gated.lock.violations)
    for status in ORDER:
        if status is not Status.PASSED:
            lines += _section(status, gated)
    lines += _listed("Warnings", gated.warnings)
    lines += _listed("Notes", (*gated.lock.notes, *gated.notes))
    return "\n".join([*lines, *_schemes(gated.outcomes)]) + "\n"


def _listed(title: str, lines: Iterable[str]) -> list[str]:
    items = [f"- {escaped(line)}" for line in shortened(list(lines), MOST)]
    return [f"### {title}", "", *items, ""] if items else []


def _section(status: Status, gated: Gated) -> list[str]:
    chosen = [outcome for outcome in gated.outcomes if outcome.status is status]
    if not chosen:
        return []
    head = [f"### {WORDS[status].capitalize()}", "", "| scheme | problem | what | claim | estimate | why | command |"]
    rows = [_row(outcome, gated) for outcome in chosen[:MOST]]
    more = [f"and {len(chosen) - MOST} more, see verdicts.csv", ""] if len(chosen) > MOST else []
    return [*head, "|---|---|---|---|---|---|---|", *rows, "", *more]


def _row(outcome: Outcome, gated: Gated) -> str:
    cell, finding = outcome.cell, outcome.finding
    why = f"{finding.reason} (expected: {outcome.expected})" if outcome.expected else str(finding.reason)
    texts = (
        cell.scheme.label,
        cell.spec.label,
        f"{cell.measure.name} {finding.quantity}".strip(),
        outcome.claim,
        estimate_text(finding, gated.settings.confidence),
        why,
        gated.command(outcome),
    )
    return f"| {' | '.join(map(escaped, texts))} |"


def _schemes(outcomes: Iterable[Outcome]) -> Iterator[str]:
    counts: dict[str, Counter[Status]] = {}
    for outcome in outcomes:
        counts.setdefault(outcome.cell.scheme.label, Counter())[outcome.status] += 1
    used = [status for status in ORDER[::-1] if any(count[status] for count in counts.values())]
    if used:
        yield f"| scheme | {' | '.join(WORDS[status] for status in used)} |"
        yield f"|---|{'---|' * len(used)}"
        for scheme, count in sorted(counts.items()):
            yield f"| {escaped(scheme)} | {' | '.join(str(count[status]) for status in used)} |"
