"""With which exit code a run or a gate ends that came to its end."""

from collections.abc import Iterable, Sequence

from ..contracts.finding import UNMEASURED, Verdict
from ..gate.outcomes import Outcome, Status, is_red
from ..gate.policy import Policy
from ..study import CellResult
from ..study.class_results import is_of_class
from .exit_codes import ExitCode


def code_of_results(results: Iterable[CellResult]) -> ExitCode:
    """Return the code of a run that came to its end, by what is found of cells and of classes of equations."""
    known = [*results]
    verdicts = {finding.verdict for result in known for finding in result.findings}
    of_cells = {finding.verdict for result in known if not is_of_class(result.cell) for finding in result.findings}
    if Verdict.REFUTED in verdicts:
        return ExitCode.REFUTED
    if verdicts & UNMEASURED:
        return ExitCode.NOT_MEASURED
    return ExitCode.NOTHING if of_cells <= {Verdict.NOT_APPLICABLE} else ExitCode.OK


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
    worst_first = {
        Status.FAILED: ExitCode.REFUTED,
        Status.UNMEASURED: ExitCode.NOT_MEASURED,
        Status.XPASSED: ExitCode.UNEXPECTED,
        Status.UNDECIDED: ExitCode.UNDECIDED,
    }
    return next((code for status, code in worst_first.items() if status in red), ExitCode.OK)
