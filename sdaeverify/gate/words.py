"""Reports of a gate: outcomes in words, text for a terminal, and ``gate.json`` for programs."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from math import isfinite, isnan
from textwrap import shorten

from ..contracts.finding import SAMPLED, Finding, Status
from ..contracts.settings import Settings
from ..report.plain import visible
from ..report.tables.command import examination_command, orders_command, reproduce
from ..report.verdict_row import VerdictRow
from .gated import WORDS, Gated
from .outcomes import Outcome

SCHEMA = 2
MOST = 20
# Longest reason in characters; most reasons have half as many.
LONGEST = 240
# Statuses that are reported in full; the others with their first line.
FULL = frozenset({Status.FAILED, Status.UNMEASURED, Status.XPASSED})


def headline(outcome: Outcome) -> str:
    """Return an outcome in one line: status, key and claim."""
    return visible(f"{WORDS[outcome.status]}: {outcome.key}: claimed {outcome.claim}")


def command_of(outcome: Outcome, settings: Settings, plugins: Sequence[str] = ()) -> str:
    """Return the command that reproduces the cell of an outcome.

    Parameters
    ----------
    outcome : Outcome
    settings : Settings
    plugins : sequence of str
        Plugins that were named: paths of files, and texts of sources.
    """
    if (kind := outcome.cell.class_name) is not None:
        return orders_command(outcome.cell.scheme.label, kind, plugins=plugins)
    return reproduce(outcome.key[:3], settings, plugins)


def message(outcome: Outcome, settings: Settings, command: str = "") -> str:
    """Return an outcome in words on several lines.

    Parameters
    ----------
    outcome : Outcome
    settings : Settings
    command : str
        Command that reproduces the outcome, from `command_of`; omitted if empty.

    Returns
    -------
    str
        Without control characters other than line ends.
    """
    finding = outcome.finding
    lines = {
        "source": finding.claim.source if finding.claim else "",
        "estimate": _estimate(finding, settings.confidence),
        "reason": str(finding.reason),
        "method": str(finding.method or ""),
        "expected to fail": outcome.expected,
        "reproduce": command,
    }
    told = (visible(f"  {name}: {text}") for name, text in lines.items() if text)
    return "\n".join([headline(outcome), *told])


def gated_command(gated: Gated, outcome: Outcome) -> str:
    """Return the command that reproduces an outcome of a gate, or an empty string if there is none."""
    if {*outcome.key} & gated.unnamed:
        return ""
    if (words := gated.examined.get(outcome.key.measure)) is not None:
        return examination_command(outcome.key[:3], words, gated.plugins)
    return command_of(outcome, gated.settings, gated.plugins)


def text_report(gated: Gated, most: int = MOST) -> Iterator[str]:
    """Yield the lines of a report.

    Parameters
    ----------
    gated : Gated
    most : int
        Largest number of outcomes reported in full, and of those reported in one line.
    """
    full = [outcome for outcome in gated.not_passed if outcome.status in FULL or gated.is_red(outcome)]
    for outcome in full[:most]:
        yield from message(outcome, gated.settings, gated_command(gated, outcome)).split("\n")
        yield ""
    if len(full) > most:
        yield f"and {len(full) - most} more that fail, see gate.json"
    yield from limit_lines([_one_line(outcome) for outcome in gated.not_passed if outcome not in full], most)
    yield from (visible(f"lock file: {line}") for line in limit_lines(gated.violations, 2 * most))
    yield from (visible(f"hunt: {line}") for line in gated.hunted)
    yield from (visible(f"changed: {line}") for line in limit_lines([*map(str, gated.changes or ())], most))
    yield from (visible(f"warning: {line}") for line in gated.warnings)
    yield from (visible(f"note: {line}") for line in gated.notes)
    yield gated.budget
    yield gated.summary


def limit_lines(lines: Sequence[str], most: int) -> list[str]:
    """Return the first `most` lines, followed by the number of omitted lines."""
    more = len(lines) - most
    return [*lines[:most], f"and {more} more"] if more > 0 else list(lines)


def json_report(gated: Gated) -> dict[str, object]:
    """Return the contents of ``gate.json``; unknown numbers are null.

    Parameters
    ----------
    gated : Gated

    Returns
    -------
    dict
    """
    return {
        "schema_version": SCHEMA,
        "exit_code": int(gated.code),
        "meaning": gated.words,
        "tier": gated.policy.tier,
        "seed": gated.settings.seed,
        "alpha": gated.policy.alpha,
        "paths": gated.settings.paths,
        "steps": list(gated.settings.steps),
        "counts": {str(status): count for status, count in sorted(gated.counts.items())},
        "lock_violations": [*map(visible, gated.violations)],
        "hunt": [*map(visible, gated.hunted)],
        "attacks": [asdict(attack) for attack in gated.attacks],
        "warnings": [*map(visible, gated.warnings)],
        "notes": [*map(visible, gated.notes)],
        "changes": None
        if gated.changes is None
        else [{**key._asdict(), "before": before, "now": now} for key, before, now in gated.changes],
        "outcomes": [_row(outcome, gated) for outcome in gated.outcomes],
    }


def _estimate(finding: Finding, confidence: float) -> str:
    """Return the estimate with its interval in words; empty without an estimate."""
    if isnan(finding.estimate):
        return "none, and no interval: no sampling was needed" if finding.method and finding.tier < SAMPLED else ""
    if not (isfinite(finding.low) and isfinite(finding.high)):
        return f"{finding.estimate:.4g}"
    interval = f"between {finding.low:.4g} and {finding.high:.4g}"
    return f"{finding.estimate:.4g}, {interval} ({100 * confidence:.4g} % interval)"


def _one_line(outcome: Outcome) -> str:
    why = outcome.expected if outcome.status is Status.XFAILED else str(outcome.finding.reason)
    return ": ".join(filter(None, (headline(outcome), shorten(visible(why), LONGEST, placeholder=" ..."))))


def _row(outcome: Outcome, gated: Gated) -> dict[str, object]:
    """Return the row of verdicts.csv of an outcome, with its status in the gate."""
    row = {
        **VerdictRow.from_finding(outcome.finding, outcome.result).record,
        "status": str(outcome.status),
        "red": gated.is_red(outcome),
        "expected": outcome.expected,
        "reproduce": gated_command(gated, outcome),
    }
    return {name: visible(value) if isinstance(value, str) else value for name, value in row.items()}
