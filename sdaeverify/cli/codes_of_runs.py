"""Exit codes of completed runs and gates."""

from collections.abc import Iterable, Sequence

from ..contracts.finding import UNMEASURED, Status, Verdict
from ..gate.outcomes import Outcome, is_red
from ..gate.policy import Policy
from ..study import CellResult
from .exit_codes import ExitCode


def code_of_verdicts(verdicts: Iterable[Verdict]) -> ExitCode:
    """Return the exit code of verdicts: refuted before not measured; `NOTHING` if all are not applicable."""
    known = {*verdicts}
    if Verdict.REFUTED in known:
        return ExitCode.REFUTED
    if known & UNMEASURED:
        return ExitCode.NOT_MEASURED
    return ExitCode.NOTHING if known <= {Verdict.NOT_APPLICABLE} else ExitCode.OK


def code_of_results(results: Iterable[CellResult]) -> ExitCode:
    """Return the exit code of a completed run.

    If it is `OK`, findings about classes of equations are ignored: they alone do not make a run successful.
    """
    known = [*results]
    code = code_of_verdicts(finding.verdict for result in known for finding in result.findings)
    of_problems = (result for result in known if result.cell.class_name is None)
    of_cells = (finding.verdict for result in of_problems for finding in result.findings)
    return code_of_verdicts(of_cells) if code is ExitCode.OK else code


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
