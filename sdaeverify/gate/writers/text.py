"""A gate for readers: in words for a terminal, and in Markdown with the counts of each scheme."""

from collections import Counter
from collections.abc import Iterable, Iterator
from textwrap import shorten

from ...report.markdown import escape
from ...report.plain import visible
from ..gated import WORDS, Gated, limit_lines
from ..outcomes import ORDER, Outcome, Status
from .messages import estimate_text, headline, message, remark

MOST = 20
# A step summary may hold 1 MiB; a row rarely takes more than 2 KiB.
MOST_ROWS = 200
# Letters of a reason; most have half as many.
LONGEST = 240
# Told in full; of the others the first line says enough.
FULL = frozenset({Status.FAILED, Status.UNMEASURED, Status.XPASSED})


def text_report(gated: Gated) -> Iterator[str]:
    """Yield the lines of a report.

    Parameters
    ----------
    gated : Gated
    """
    full = [outcome for outcome in gated.not_passed if _needs_full_text(outcome, gated)]
    for outcome in full[:MOST]:
        yield from message(outcome, gated.settings, gated.command(outcome)).split("\n")
        yield ""
    if len(full) > MOST:
        yield f"and {len(full) - MOST} more that fail, see gate.md"
    yield from limit_lines(
        [_one_line_text(outcome) for outcome in gated.not_passed if not _needs_full_text(outcome, gated)], MOST
    )
    yield from (visible(f"lock file: {line}") for line in limit_lines(gated.lock.violations, 2 * MOST))
    yield from (visible(f"warning: {line}") for line in gated.warnings)
    yield from (visible(f"note: {line}") for line in (*gated.lock.notes, *gated.notes))
    yield gated.budget
    yield gated.summary


def _one_line_text(outcome: Outcome) -> str:
    why = shorten(visible(remark(outcome)), LONGEST, placeholder=" ...")
    return f"{headline(outcome)}: {why}" if why else headline(outcome)


def _needs_full_text(outcome: Outcome, gated: Gated) -> bool:
    return outcome.status in FULL or gated.is_red(outcome)


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
        f"## {sign} sdaeverify gate: {escape(gated.words)}",
        "",
        f"{gated.summary}.",
        "",
        f"{gated.budget}.",
        "",
    ]
    lines += _bullets("Lock file", gated.lock.violations)
    for status in ORDER:
        if status is not Status.PASSED:
            lines += _section(status, gated)
    lines += _bullets("Warnings", gated.warnings)
    lines += _bullets("Notes", (*gated.lock.notes, *gated.notes))
    return "\n".join([*lines, *_schemes(gated.outcomes)]) + "\n"


def _bullets(title: str, lines: Iterable[str]) -> list[str]:
    items = [f"- {escape(line)}" for line in limit_lines(list(lines), MOST_ROWS)]
    return [f"### {title}", "", *items, ""] if items else []


def _section(status: Status, gated: Gated) -> list[str]:
    chosen = [outcome for outcome in gated.outcomes if outcome.status is status]
    if not chosen:
        return []
    head = [f"### {WORDS[status].capitalize()}", "", "| scheme | problem | what | claim | estimate | why | command |"]
    rows = [_row(outcome, gated) for outcome in chosen[:MOST_ROWS]]
    more = [f"and {len(chosen) - MOST_ROWS} more, see verdicts.csv", ""] if len(chosen) > MOST_ROWS else []
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
    return f"| {' | '.join(map(escape, texts))} |"


def _schemes(outcomes: Iterable[Outcome]) -> Iterator[str]:
    counts: dict[str, Counter[Status]] = {}
    for outcome in outcomes:
        counts.setdefault(outcome.cell.scheme.label, Counter())[outcome.status] += 1
    used = [status for status in ORDER[::-1] if any(count[status] for count in counts.values())]
    if used:
        yield f"| scheme | {' | '.join(WORDS[status] for status in used)} |"
        yield f"|---|{'---|' * len(used)}"
        for scheme, count in sorted(counts.items()):
            yield f"| {escape(scheme)} | {' | '.join(str(count[status]) for status in used)} |"
