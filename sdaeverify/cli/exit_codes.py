"""Exit codes: one meaning each, never a count, printed in words at the end of a run."""

from collections.abc import Iterable
from enum import IntEnum

from ..errors import PluginError, SdaeverifyError, UsageError
from ..measure import Verdict
from ..study import CellResult


class ExitCode(IntEnum):
    """What a run came to."""

    OK = 0
    REFUTED = 1
    USAGE = 2
    NOT_MEASURED = 3
    NOTHING = 5
    PLUGIN = 6
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
    ExitCode.NOTHING: "nothing was there to be measured",
    ExitCode.PLUGIN: "a requested plugin failed to load",
    ExitCode.INTERRUPTED: "interrupted; what was finished is saved",
}


def code_of_results(results: Iterable[CellResult]) -> ExitCode:
    """Return the code of a run that came to its end."""
    verdicts = {finding.verdict for result in results for finding in result.findings}
    if Verdict.REFUTED in verdicts:
        return ExitCode.REFUTED
    if verdicts & {Verdict.ERROR, Verdict.DIVERGED, Verdict.NOT_RUN}:
        return ExitCode.NOT_MEASURED
    return ExitCode.NOTHING if verdicts <= {Verdict.NOT_APPLICABLE} else ExitCode.OK


def code_of_error(error: SdaeverifyError) -> ExitCode:
    """Return the code of an error meant for the user."""
    if isinstance(error, PluginError):
        return ExitCode.PLUGIN
    return ExitCode.USAGE if isinstance(error, UsageError) else ExitCode.NOT_MEASURED
