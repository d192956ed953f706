"""Exit codes of completed runs and gates."""

from collections.abc import Iterable, Sequence

from ..contracts.finding import UNMEASURED, Verdict
from ..gate.outcomes import Outcome, Status, is_red
from ..gate.policy import Policy
from ..study import CellResult
from ..trees.class_row import ClassRow, ClassVerdict
from .exit_codes import ExitCode


def code_of_results(results: Iterable[CellResult], class_rows: Iterable[ClassRow] = ()) -> ExitCode:
    """Return the exit code of a completed run from its findings and its rows of classes."""
    verdicts = {finding.verdict for result in results for finding in result.findings}
    if Verdict.REFUTED in verdicts or any(row.verdict is ClassVerdict.REFUTED for row in class_rows):
        return ExitCode.REFUTED
    if verdicts & UNMEASURED:
        return ExitCode.NOT_MEASURED
    return ExitCode.NOTHING if verdicts <= {Verdict.NOT_APPLICABLE} else ExitCode.OK


def code_of_gate(outcomes: Sequence[Outcome], policy: Policy, *, complete: bool) -> ExitCode:
    """Return the exit code of a gate: that of its worst failing outcome, or 0.

    Parameters
    ----------
    outcomes : sequence of Outcome
    policy : Policy
    complete : bool
        Whether all locked claims are found and all claims are tested. If not, `NOTHING` precedes every outcome.
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
