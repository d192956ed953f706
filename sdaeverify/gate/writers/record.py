"""A gate for programs: ``gate.json``."""

from ...report.plain import visible
from ...report.verdict_row import VerdictRow
from ..gated import Gated
from ..outcomes import Outcome

SCHEMA = 2


def json_report(gated: Gated) -> dict[str, object]:
    """Return the contents of ``gate.json``; a number that is not known is null.

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
        "lock_violations": [visible(line) for line in gated.violations],
        "warnings": [visible(line) for line in gated.warnings],
        "notes": [visible(line) for line in gated.notes],
        "outcomes": [_row(outcome, gated) for outcome in gated.outcomes],
    }


def _row(outcome: Outcome, gated: Gated) -> dict[str, object]:
    """Return the row of verdicts.csv that an outcome is, and what it means for the gate."""
    row = {
        **VerdictRow.from_finding(outcome.finding, outcome.result).record,
        "status": str(outcome.status),
        "red": gated.is_red(outcome),
        "expected": outcome.expected,
        "reproduce": gated.command(outcome),
    }
    return {name: visible(value) if isinstance(value, str) else value for name, value in row.items()}
