"""Exit codes: one meaning each, never a count, printed in words at the end of a run."""

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum

from ..contracts.finding import UNMEASURED, Verdict
from ..errors import PluginError, SdaeverifyError, UsageError
from ..gate.outcomes import Outcome, Status, is_red
from ..gate.policy import Policy
from ..study import CellResult
from ..trees.class_row import ClassRow, ClassVerdict


class ExitCode(IntEnum):
    """What a run came to."""

    OK = 0, "no claim is refuted"
    REFUTED = 1, "a claim is refuted"
    USAGE = 2, "the command line is wrong"
    NOT_MEASURED = 3, "cells could not be measured"
    UNDECIDED = 4, "a claim is undecided, and must not be"
    NOTHING = 5, "nothing was there to be measured, or less than is claimed or locked"
    PLUGIN = 6, "a requested plugin failed to load"
    UNEXPECTED = 7, "a claim is verified that was expected to fail"
    INTERRUPTED = 130, "interrupted; what was finished is saved"

    words: str

    def __new__(cls, value: int, words: str = "") -> "ExitCode":
        """Return the code with its meaning."""
        code = int.__new__(cls, value)
        code._value_, code.words = value, words
        return code


WORDS = {code: code.words for code in ExitCode}


def codes_in_words(words: Mapping[ExitCode, str] = WORDS) -> str:
    """Return the sentence in which the help of a command tells its codes."""
    return f"Exit codes: {'; '.join(f'{code.value} {meaning}' for code, meaning in words.items())}."


def code_of_error(error: SdaeverifyError) -> ExitCode:
    """Return the code of an error meant for the user."""
    if isinstance(error, PluginError):
        return ExitCode.PLUGIN
    return ExitCode.USAGE if isinstance(error, UsageError) else ExitCode.NOT_MEASURED


def code_of_results(results: Iterable[CellResult], class_rows: Iterable[ClassRow] = ()) -> ExitCode:
    """Return the code of a run that came to its end, by what is found of cells and of classes of equations."""
    verdicts = {finding.verdict for result in results for finding in result.findings}
    if Verdict.REFUTED in verdicts or any(row.verdict is ClassVerdict.REFUTED for row in class_rows):
        return ExitCode.REFUTED
    if verdicts & UNMEASURED:
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
    worst_first = {
        Status.FAILED: ExitCode.REFUTED,
        Status.UNMEASURED: ExitCode.NOT_MEASURED,
        Status.XPASSED: ExitCode.UNEXPECTED,
        Status.UNDECIDED: ExitCode.UNDECIDED,
    }
    return next((code for status, code in worst_first.items() if status in red), ExitCode.OK)
