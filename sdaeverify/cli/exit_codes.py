"""Exit codes: one meaning each, never a count, printed in words at the end of a run."""

from collections.abc import Mapping
from enum import IntEnum

from ..errors import PluginError, SdaeverifyError, UsageError


class ExitCode(IntEnum):
    """What a run came to."""

    OK = 0, "no claim is refuted"
    REFUTED = 1, "a claim is refuted"
    USAGE = 2, "the command line is wrong"
    NOT_MEASURED = 3, "cells could not be measured"
    UNDECIDED = 4, "a claim is inconclusive, and the policy forbids it"
    NOTHING = 5, "nothing was measured, or not all that is claimed or locked"
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
