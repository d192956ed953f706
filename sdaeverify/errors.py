"""Errors a user can cause, one line each; anything else that is raised is a defect of sdaeverify.

::

    SdaeverifyError
    ├── UsageError            wrong words: unknown names, contradictory options      exit code 2
    │   └── ParameterError    a parameter of a scheme or problem has a wrong value   exit code 2
    ├── ProblemError          a problem contradicts itself                           its cells: error
    ├── SchemeError           a scheme breaks its contract                           its cells: error
    └── PluginError           a plugin cannot be loaded                              exit code 6
        └── MissingLibraryError   the library it is made for is not installed       it is left out
"""


class SdaeverifyError(Exception):
    """Base of all errors with a message meant for the user."""


class UsageError(SdaeverifyError, ValueError):
    """The request itself is wrong."""


class ParameterError(UsageError):
    """A parameter of a scheme or problem has a wrong name or value."""


class ProblemError(SdaeverifyError, ValueError):
    """A problem's data contradict each other or have the wrong shape."""


class SchemeError(SdaeverifyError, ValueError):
    """A scheme returned something its contract does not allow."""


class PluginError(SdaeverifyError, ImportError):
    """A plugin could not be loaded or registers something unusable."""


class MissingLibraryError(PluginError):
    """The library that a plugin is made for is not installed: it is left out, and nothing is wrong with it."""


# What a plugin may raise without ending the run: sys.exit() included, an interrupt of the user not.
FAULTS = (Exception, SystemExit, GeneratorExit)


def is_out_of_memory(error: BaseException | None) -> bool:
    """Tell whether an error, or one that it was raised from, is that there is no memory left."""
    while error is not None and not isinstance(error, MemoryError):
        error = error.__cause__ or error.__context__
    return error is not None


def one_line(error: BaseException) -> str:
    """Return the type and first line of an error, for a cell of a table.

    Parameters
    ----------
    error : BaseException

    Returns
    -------
    str
        ``message`` for an error of this package, ``Type: message`` for any other.
    """
    text = " ".join(_text(error).split()) or "no message"
    return text if isinstance(error, SdaeverifyError) else f"{type(error).__name__}: {text}"


def _text(error: BaseException) -> str:
    """Return the message of an error, whose class may be a plugin's own and know no text of itself."""
    try:
        return str(error)
    except FAULTS as other:
        return f"its message cannot be read, which raises {type(other).__name__}"


def is_blank(text: str) -> bool:
    """Tell whether a text says nothing."""
    return not text.strip()
