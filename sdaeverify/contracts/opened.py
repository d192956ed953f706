"""Files that code opens in this process, with the code that opened them, as an audit hook of the interpreter reports.

Files that the framework opens for itself are left out. An audit hook reports neither files that a library opens in C
nor those of other processes. A hook cannot be removed: it is installed only in processes that simulate for a store of
evidence, before they load plugins, and not when the package is imported.
"""

import os
import sys
import sysconfig
from functools import cache
from importlib.util import source_from_cache
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote, urlsplit

# Size and time of a file; None of what is not there.
Signature = tuple[int, int] | None
EVENTS = frozenset({"open", "ctypes.dlopen", "sqlite3.connect"})
PYTHON, CACHED, INIT = ".py", ".pyc", "__init__.py"
# Folders of installed packages, and what begins the paths of others that are no data.
INSTALLED = ("site-packages", "dist-packages")
LIBRARY = tuple({sysconfig.get_path(name) + os.sep for name in ("stdlib", "platstdlib")})
SYSTEM = ("/proc/", "/sys/", "/dev/")
ROOT = Path(__file__).parents[1]
OWN = str(ROOT) + os.sep
# Frames of a library that may lie between a plugin and what it opens.
DEEPEST = 24


class Opening(NamedTuple):
    """A file that was opened, the files of the code that did it, innermost first, and whether it was only written."""

    path: str
    callers: tuple[str, ...]
    written: bool = False


@cache
def openings() -> dict[Opening, Signature]:
    """Return the files opened in this process since the first call, with their sizes and times then.

    The first call installs the audit hook.
    """
    heard: dict[Opening, Signature] = {}

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        try:
            opening = _opening(arguments) if event in EVENTS else None
            if opening is not None:
                heard[opening] = signature(opening.path)
        except Exception:
            # An exception would be raised in the code that opens the file. At exit the names of this module are gone.
            return

    sys.addaudithook(hear)
    return heard


def _opening(arguments: tuple[Any, ...]) -> Opening | None:
    path = _path_of(arguments[0])
    if path is None or path.startswith(SYSTEM):
        return None
    if path.endswith((PYTHON, CACHED)):
        if is_library(path) or path.startswith(OWN):
            return None
        path = source_from_cache(path) if path.endswith(CACHED) else path
    mode = arguments[2] if len(arguments) > 2 and isinstance(arguments[2], int) else os.O_RDONLY
    written = bool(mode & (os.O_TRUNC | os.O_EXCL)) or mode & os.O_ACCMODE == os.O_WRONLY
    callers = _callers()
    return Opening(path, callers, written) if callers else None


def signature(path: str) -> Signature:
    """Return size and time of a file; None if it is not there."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_size, found.st_mtime_ns


@cache
def home_of(file: Path) -> Path:
    """Return the top-level package that a module is in, or itself where there is none; of the framework a room."""
    if ROOT in file.parents:
        return ROOT / file.relative_to(ROOT).parts[0]
    if not (file.parent / INIT).is_file():
        return file
    return next(folder for folder in file.parents if not (folder.parent / INIT).is_file())


def is_library(path: str) -> bool:
    """Tell whether a path is that of an installed package or of the standard library."""
    return path.startswith(LIBRARY) or _is_installed(path)


def _is_installed(path: str) -> bool:
    return any(folder in path.split(os.sep) for folder in INSTALLED)


def _path_of(given: Any) -> str | None:
    """Return the absolute path of what is opened; None of a descriptor and of what is no file."""
    if not isinstance(given, str | bytes | os.PathLike):
        return None
    text = os.fsdecode(given)
    if text.startswith("file:"):
        text = unquote(urlsplit(text).path)
    return None if text in {"", ":memory:"} else os.path.abspath(text)


def _callers() -> tuple[str, ...]:
    """Return the files of the code that runs, up to the framework that called it, without the standard library."""
    found: dict[str, None] = {}
    frame, depth = sys._getframe(1), 0
    while frame is not None and frame.f_code.co_filename == __file__:
        frame = frame.f_back  # type: ignore[assignment]
    while frame is not None and depth < DEEPEST and not frame.f_code.co_filename.startswith(OWN):
        file = frame.f_code.co_filename
        if not file.startswith("<") and not (file.startswith(LIBRARY) and not _is_installed(file)):
            found[file] = None
            depth += 1
        frame = frame.f_back  # type: ignore[assignment]
    return tuple(found)
