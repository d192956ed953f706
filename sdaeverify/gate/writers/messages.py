"""What is said of an outcome: claim, estimate with interval, reason, and the command to see it again."""

from collections.abc import Sequence
from math import isfinite, isnan

from ...contracts.finding import SAMPLED, Finding
from ...contracts.settings import Settings
from ...report.plain import visible
from ...report.tables.command import reproduce
from ..outcomes import Outcome, Status

WORDS = {
    Status.PASSED: "verified",
    Status.FAILED: "refuted",
    Status.UNMEASURED: "not measured",
    Status.UNDECIDED: "undecided",
    Status.XFAILED: "fails as expected",
    Status.XPASSED: "expected to fail, but verified",
}


def title(outcome: Outcome) -> str:
    """Return what an outcome is about: ``milstein on gbm, strong x``."""
    cell = outcome.cell
    what = f"{cell.measure.name} {outcome.finding.quantity}".strip()
    return visible(f"{cell.scheme.label} on {cell.spec.label}, {what}")


def headline(outcome: Outcome) -> str:
    """Return an outcome in one line: what became of which claim."""
    return visible(f"{WORDS[outcome.status]}: {title(outcome)}: claimed {outcome.claim}")


def remark(outcome: Outcome) -> str:
    """Return why an outcome is what it is: the reason of its finding, or why that is expected."""
    return outcome.expected if outcome.status is Status.XFAILED else str(outcome.finding.reason)


def estimate_text(finding: Finding, confidence: float) -> str:
    """Return the estimate with its interval in words; empty if there is none."""
    if isnan(finding.estimate):
        return ""
    if not (isfinite(finding.low) and isfinite(finding.high)):
        return f"{finding.estimate:.4g}"
    interval = f"between {finding.low:.4g} and {finding.high:.4g}"
    return f"{finding.estimate:.4g}, {interval} ({100 * confidence:.4g} % interval)"


def command_of(outcome: Outcome, settings: Settings, plugins: Sequence[str] = ()) -> str:
    """Return the command that computes the outcome's cell again.

    Parameters
    ----------
    outcome : Outcome
    settings : Settings
    plugins : sequence of str
        Plugin files named by path.
    """
    cell = outcome.cell
    return reproduce((cell.scheme.label, cell.spec.label, cell.measure.name), settings, plugins)


def message(outcome: Outcome, settings: Settings, command: str = "") -> str:
    """Return an outcome in words, several lines.

    Parameters
    ----------
    outcome : Outcome
    settings : Settings
    command : str
        That computes it again, as `command_of` gives it; left out if empty.

    Returns
    -------
    str
        Without control characters other than line ends.
    """
    finding = outcome.finding
    source = finding.claim.source if finding.claim else ""
    lines = {
        "": headline(outcome),
        "source": source,
        "estimate": estimate_text(finding, settings.confidence) or _without_estimate(finding),
        "reason": str(finding.reason),
        "method": str(finding.method or ""),
        "expected to fail": outcome.expected,
        "reproduce": command,
    }
    return "\n".join(visible(f"  {name}: {text}" if name else text) for name, text in lines.items() if text)


def _without_estimate(finding: Finding) -> str:
    return "none, and no interval: no sampling was needed" if finding.method and finding.tier < SAMPLED else ""
