"""A gate as JSON: everything that is told in words, for programs."""

from math import isfinite

from ...report.plain import visible
from ..gated import WORDS, Gated
from ..outcomes import ORDER, Outcome, Status

SCHEMA = 1


def json_report(gated: Gated) -> dict[str, object]:
    """Return the contents of ``gate.json``; a number that is not finite is null.

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
        "lock_violations": [visible(line) for line in gated.lock.violations],
        "warnings": [visible(line) for line in gated.warnings],
        "notes": [visible(line) for line in (*gated.lock.notes, *gated.notes)],
        "outcomes": [_row(outcome, gated) for outcome in gated.outcomes],
    }


def _row(outcome: Outcome, gated: Gated) -> dict[str, object]:
    cell, finding = outcome.cell, outcome.finding
    texts = {
        "scheme": cell.scheme.label,
        "problem": cell.spec.label,
        "measure": cell.measure.name,
        "quantity": finding.quantity,
        "status": str(outcome.status),
        "verdict": str(finding.verdict),
        "claim": outcome.claim,
        "source": finding.claim.source if finding.claim else "",
        "reason": str(finding.reason),
        "method": finding.method,
        "expected": outcome.expected,
        "reproduce": gated.command(outcome),
    }
    numbers = {"estimate": finding.estimate, "ci_low": finding.low, "ci_high": finding.high}
    return {
        **{name: visible(text) for name, text in texts.items()},
        **{name: float(number) if isfinite(number) else None for name, number in numbers.items()},
        "red": gated.red(outcome),
        "paths": outcome.paths,
    }


# A badge as shields.io reads it from an address: JSON with a label, a message and a colour.


GOOD, OPEN, BAD = "brightgreen", "yellow", "red"


def badge(gated: Gated) -> dict[str, object]:
    """Return a badge that is never green while a claim is undecided or expected to fail.

    Parameters
    ----------
    gated : Gated

    Returns
    -------
    dict
    """
    counts = gated.counts
    others = [f"{counts[s]} {WORDS[s]}" for s in ORDER if counts[s] and s is not Status.PASSED]
    message = f"verified {counts[Status.PASSED]}/{len(gated.outcomes)}"
    colour = BAD if gated.code else OPEN if others else GOOD
    return {"schemaVersion": 1, "label": "sdaeverify", "message": ", ".join([message, *others]), "color": colour}
