"""Which exit code the results of a run, or the outcomes of a gate, come to."""

from collections.abc import Iterable, Sequence

from ..contracts.finding import Verdict
from ..gate.outcomes import Outcome, Status, is_red
from ..gate.policy import Policy
from ..study import CellResult
from .exit_codes import ExitCode

# What of the outcomes of a gate its code tells, worst first.
SEVERITY = {
    Status.FAILED: ExitCode.REFUTED,
    Status.UNMEASURED: ExitCode.NOT_MEASURED,
    Status.XPASSED: ExitCode.UNEXPECTED,
    Status.UNDECIDED: ExitCode.UNDECIDED,
}


def code_of_results(results: Iterable[CellResult]) -> ExitCode:
    """Return the code of a run that came to its end."""
    verdicts = {finding.verdict for result in results for finding in result.findings}
    if Verdict.REFUTED in verdicts:
        return ExitCode.REFUTED
    if verdicts & {Verdict.ERROR, Verdict.DIVERGED, Verdict.NOT_RUN}:
        return ExitCode.NOT_MEASURED
    return ExitCode.NOTHING if verdicts <= {Verdict.NOT_APPLICABLE} else ExitCode.OK


def code_of_gate(outcomes: Sequence[Outcome], policy: Policy, *, complete: bool) -> ExitCode:
    """Return the code of a gate: that of the worst outcome that fails it, nothing being worse than any outcome.

    Parameters
    ----------
    outcomes : sequence of Outcome
    policy : Policy
    complete : bool
        Whether all that the lock file demands is there, and all that is claimed is tested.
    """
    if not outcomes or not complete:
        return ExitCode.NOTHING
    red = {outcome.status for outcome in outcomes if is_red(outcome, policy)}
    return next((code for status, code in SEVERITY.items() if status in red), ExitCode.OK)
