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

import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from traceback import format_exception, walk_tb


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


__all__ = [
    "FAULTS",
    "MissingLibraryError",
    "ParameterError",
    "PluginError",
    "ProblemError",
    "SchemeError",
    "SdaeverifyError",
    "UsageError",
    "one_line",
]

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
        ``message`` for an error of this package; for any other ``Type: message``, with the file and the line of the
        plugin that raised it, or that called what did. Of a call with wrong arguments, the right ones as well.
    """
    text = " ".join(_text(error).split()) or "no message"
    if isinstance(error, SdaeverifyError):
        return text
    place, expected = _line_of_plugin(error), _signature(error, text)
    told = f"{text}; expected {expected}" if expected else text
    return f"{type(error).__name__}: {told}{f' ({place})' if place else ''}"


def with_traceback(error: BaseException) -> str:
    """Return `one_line` of an error, and below it its traceback, with those of the errors that it was raised from.

    Parameters
    ----------
    error : BaseException
    """
    return f"{one_line(error)}\n{''.join(format_exception(error)).rstrip()}"


def _text(error: BaseException) -> str:
    """Return the message of an error, whose class may be a plugin's own and know no text of itself."""
    try:
        return str(error)
    except FAULTS as other:
        return f"its message cannot be read, which raises {type(other).__name__}"


# How Python tells of a call with wrong arguments.
_CALL = re.compile(r"(?:\S*\.)?(?P<name>\w+)\(\) (?:missing|takes|got an unexpected)")


def _signature(error: BaseException, text: str) -> str:
    """Return what was called with wrong arguments with the right ones, such as ``DelaySDAE.diffused(t, x, v, y, w)``.

    It is empty for any other error, and where no object that the caller knows has a function of this name.
    """
    called = _CALL.match(text) if isinstance(error, TypeError) else None
    frames = [frame for frame, _ in walk_tb(error.__traceback__)]
    if called is None or not frames:
        return ""
    for owner in [*frames[-1].f_locals.values()]:
        # Nothing is called: an attribute may be a property of a plugin.
        function = inspect.getattr_static(owner, called["name"], None)
        if inspect.isfunction(function) and not isinstance(owner, type):
            arguments = [name for name in inspect.signature(function).parameters if name != "self"]
            return f"{type(owner).__name__}.{function.__name__}({', '.join(arguments)})"
    return ""


FRAMEWORK = __name__.partition(".")[0]
# Arrays raise where they are misused, which is told of who misuses them; hooks are called through pluggy.
PASSED = frozenset({"numpy", "scipy", "pluggy"})


def _line_of_plugin(error: BaseException) -> str:
    """Return the last line of the plugin that the framework called last; empty where it called none.

    What a plugin calls in its turn, another library or the framework, is not where its author looks.
    """
    found = inside = ""
    for package, line in _lines(error):
        if package == FRAMEWORK:
            inside = ""
        elif not inside or package == inside:
            found, inside = line, package
    return found


def _lines(error: BaseException) -> Iterator[tuple[str, str]]:
    """Yield the package and the line of each call that an error has passed, outermost first.

    Calls of Python's own library and of arrays are left out.
    """
    for frame, number in walk_tb(error.__traceback__):
        module, path = str(frame.f_globals.get("__name__", "")), Path(frame.f_code.co_filename)
        package, folders = module.partition(".")[0], module.count(".") + (path.stem == "__init__")
        file = "/".join(path.parts[-folders - 1 :])
        if package not in sys.stdlib_module_names | PASSED and not file.startswith("<"):
            yield package, f"{file}:{number}"


def is_blank(text: str) -> bool:
    """Tell whether a text says nothing."""
    return not text.strip()
