"""Exit codes: one meaning each, never a count, printed in words at the end of a run."""

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum

from ..contracts.finding import UNMEASURED, Verdict
from ..errors import PluginError, SdaeverifyError, UsageError
from ..gate.outcomes import Outcome, Status, is_red
from ..gate.policy import Policy
from ..study import CellResult


class ExitCode(IntEnum):
    """What a run came to."""

    OK = 0
    REFUTED = 1
    USAGE = 2
    NOT_MEASURED = 3
    UNDECIDED = 4
    NOTHING = 5
    PLUGIN = 6
    UNEXPECTED = 7
    INTERRUPTED = 130

    @property
    def words(self) -> str:
        """The meaning."""
        return WORDS[self]


WORDS = {
    ExitCode.OK: "no claim is refuted",
    ExitCode.REFUTED: "a claim is refuted",
    ExitCode.USAGE: "the command line is wrong",
    ExitCode.NOT_MEASURED: "cells could not be measured",
    ExitCode.UNDECIDED: "a claim is undecided, and must not be",
    ExitCode.NOTHING: "nothing was there to be measured, or less than is claimed or locked",
    ExitCode.PLUGIN: "a requested plugin failed to load",
    ExitCode.UNEXPECTED: "a claim is verified that was expected to fail",
    ExitCode.INTERRUPTED: "interrupted; what was finished is saved",
}


def codes_in_words(words: Mapping[ExitCode, str] = WORDS) -> str:
    """Return the sentence in which the help of a command tells its codes."""
    return f"Exit codes: {'; '.join(f'{code.value} {meaning}' for code, meaning in words.items())}."


def code_of_error(error: SdaeverifyError) -> ExitCode:
    """Return the code of an error meant for the user."""
    if isinstance(error, PluginError):
        return ExitCode.PLUGIN
    return ExitCode.USAGE if isinstance(error, UsageError) else ExitCode.NOT_MEASURED


def code_of_results(results: Iterable[CellResult]) -> ExitCode:
    """Return the code of a run that came to its end."""
    verdicts = {finding.verdict for result in results for finding in result.findings}
    if Verdict.REFUTED in verdicts:
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
