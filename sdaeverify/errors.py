"""Errors that users can cause, with one-line messages; any other exception is a defect of sdaeverify.

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
import linecache
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from traceback import FrameSummary, extract_tb, format_exception, walk_tb
from types import FrameType, TracebackType


class SdaeverifyError(Exception):
    """Base of all errors with a message meant for the user."""


class UsageError(SdaeverifyError, ValueError):
    """An invalid request: unknown names, contradictory options or values out of range."""


class ParameterError(UsageError):
    """A parameter of a scheme or problem has a wrong name or value."""


class ProblemError(SdaeverifyError, ValueError):
    """A problem's data contradict each other or have the wrong shape."""


class SchemeError(SdaeverifyError, ValueError):
    """A scheme violates its contract."""


class PluginError(SdaeverifyError, ImportError):
    """A plugin cannot be loaded or registers an unusable object."""


class MissingLibraryError(PluginError):
    """The library that a plugin is made for is not installed: the plugin is left out without being an error."""


# Public in addition to those of `sdaeverify`.
__all__ = ["FAULTS", "MissingLibraryError", "PluginError", "one_line"]

# Exceptions that a plugin may raise without ending the run, sys.exit() included; an interrupt by the user ends it.
FAULTS = (Exception, SystemExit, GeneratorExit)


def is_out_of_memory(error: BaseException | None) -> bool:
    """Return whether an error, or one from which it was raised, is a MemoryError."""
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
        ``message`` for an error of this package. For any other error ``Type: message``, followed by the correct
        arguments if it was a call with wrong ones, or by the call if the framework made it, and by the file and line
        in the plugin that raised it or called the raising code.
    """
    text = " ".join(_text(error).split()) or "no message"
    if isinstance(error, SdaeverifyError):
        return text
    place, called = _line_of_plugin(error), _wrong_call(error, text)
    message = f"{text}; {called}" if called else text
    return f"{type(error).__name__}: {message}{f' ({place})' if place else ''}"


def with_traceback(error: BaseException) -> str:
    """Return `one_line` of an error, followed by its traceback and those of the errors from which it was raised.

    The traceback begins where the framework calls a plugin, whose author need not know the calls before.

    Parameters
    ----------
    error : BaseException
    """
    trace = format_exception(type(error), error, _from_plugin_on(error.__traceback__))
    return f"{one_line(error)}\n{''.join(trace).rstrip()}"


def _from_plugin_on(trace: TracebackType | None) -> TracebackType | None:
    """Return a traceback without the frames before the first one of a plugin; whole if it has none."""
    rest = trace
    while rest is not None:
        package = str(rest.tb_frame.f_globals.get("__name__", "")).partition(".")[0]
        if package not in {FRAMEWORK, *sys.stdlib_module_names, *PASSED}:
            return rest
        rest = rest.tb_next
    return trace


def _text(error: BaseException) -> str:
    """Return the message of an error, also if its ``__str__``, which may be a plugin's, raises."""
    try:
        return str(error)
    except FAULTS as other:
        return f"its message cannot be read, which raises {type(other).__name__}"


# Python's messages for a call with wrong arguments, by the qualified name of the function.
_CALL = re.compile(r"(?P<name>\S+)\(\) (?:missing|takes|got an unexpected)")


def _wrong_call(error: BaseException, text: str) -> str:
    """Return what a call with wrong arguments should have been, or how the framework makes it; empty otherwise.

    ``expected DelaySDAE.diffused(t, x, v, y, w)`` if a local object of the caller has the function. Otherwise
    ``called as observable(0.0, initial)`` if the framework calls a function of a plugin, for example a lambda, whose
    name does not say what it is.
    """
    called = _CALL.match(text) if isinstance(error, TypeError) else None
    frames = extract_tb(error.__traceback__)
    if called is None or not frames:
        return ""
    *_, (frame, _) = walk_tb(error.__traceback__)
    if expected := _signature(frame, called["name"]):
        return f"expected {expected}"
    by_framework = str(frame.f_globals.get("__name__", "")).partition(".")[0] == FRAMEWORK
    call = _source(frames[-1]) if by_framework else ""
    return f"called as {call}" if call else ""


def _signature(frame: FrameType, name: str) -> str:
    """Return the signature of the method `name` (qualified) of a local object of a frame; empty if none has it."""
    for owner in [*frame.f_locals.values()]:
        # Static look-up, because an attribute may be a property of a plugin, which must not be called.
        function = inspect.getattr_static(owner, name.rpartition(".")[2], None)
        if not inspect.isfunction(function) or isinstance(owner, type) or function.__qualname__ != name:
            continue
        arguments = [each for each in inspect.signature(function).parameters if each != "self"]
        return f"{type(owner).__name__}.{function.__name__}({', '.join(arguments)})"
    return ""


def _source(frame: FrameSummary) -> str:
    """Return the expression at which a frame raised; empty if it is not known or has several lines."""
    first, last = frame.colno, frame.end_colno
    if frame.lineno is None or first is None or last is None or frame.lineno != frame.end_lineno:
        return ""
    # Columns count bytes of the line in the file; the attribute `line` is stripped.
    return linecache.getline(frame.filename, frame.lineno).encode()[first:last].decode()


FRAMEWORK = __name__.partition(".")[0]
# Numerical libraries raise errors of their callers, so the caller's line is reported; hooks are called through
# pluggy.
PASSED = frozenset({"numpy", "scipy", "pluggy"})


def _line_of_plugin(error: BaseException) -> str:
    """Return the last line in the plugin that the framework called last; empty if it called none.

    Lines in other libraries that the plugin calls, or in the framework, are skipped because they do not help its
    author. A package that calls plugins of others, as tests of classes do, counts as framework if it has a true
    `CALLS_PLUGINS`.
    """
    found = inside = ""
    for package, line in _lines(error):
        if package == FRAMEWORK or getattr(sys.modules.get(package), "CALLS_PLUGINS", False):
            inside = ""
        elif not inside or package == inside:
            found, inside = line, package
    return found


def _lines(error: BaseException) -> Iterator[tuple[str, str]]:
    """Yield the package and the line of each frame of an error's traceback, outermost first.

    Frames of the standard library and of `PASSED` are skipped.
    """
    for frame, number in walk_tb(error.__traceback__):
        module, path = str(frame.f_globals.get("__name__", "")), Path(frame.f_code.co_filename)
        package, folders = module.partition(".")[0], module.count(".") + (path.stem == "__init__")
        file = "/".join(path.parts[-folders - 1 :])
        if package not in sys.stdlib_module_names | PASSED and not file.startswith("<"):
            yield package, f"{file}:{number}"


def is_blank(text: str) -> bool:
    """Return whether a text is empty or consists of white space."""
    return not text.strip()
