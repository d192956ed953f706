"""Exit codes with one meaning for all commands. They are never counts, and are printed in words after a run."""

from enum import IntEnum

from ..errors import PluginError, SdaeverifyError, UsageError


class ExitCode(IntEnum):
    """Exit code with its meaning as `words`."""

    OK = 0, "no claim is refuted, and no check fails"
    REFUTED = 1, "a claim is refuted, or a check fails"
    USAGE = 2, "the command line is wrong"
    NOT_MEASURED = 3, "something could not be measured"
    UNDECIDED = 4, "a claim is undecided, and must not be"
    NOTHING = 5, "nothing was there to be measured, or less than is claimed or locked"
    PLUGIN = 6, "a requested plugin failed to load"
    UNEXPECTED = 7, "a claim is verified that was expected to fail"
    INTERRUPTED = 130, "interrupted; what was finished is saved"

    words: str

    def __new__(cls, value: int, words: str = "") -> "ExitCode":
        """Create a code with its meaning."""
        code = int.__new__(cls, value)
        code._value_, code.words = value, words
        return code


def codes_in_words(*codes: ExitCode) -> str:
    """Return the sentence on exit codes for the help of a command; all exit codes if no code is given."""
    return f"Exit codes: {'; '.join(f'{code.value} {code.words}' for code in codes or ExitCode)}."


def code_of_error(error: SdaeverifyError) -> ExitCode:
    """Return the exit code of an error that is reported to the user."""
    if isinstance(error, PluginError):
        return ExitCode.PLUGIN
    return ExitCode.USAGE if isinstance(error, UsageError) else ExitCode.NOT_MEASURED
