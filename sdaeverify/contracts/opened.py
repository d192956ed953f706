"""Files opened in this process with the code that opened them, recorded by an audit hook of the interpreter.

Files that the framework opens for itself are excluded. An audit hook reports neither files that a library opens in C
nor those of other processes. A hook cannot be removed, so it is installed only in processes that simulate for a store
of evidence, before they load plugins, and not when the package is imported.
"""

import os
import sys
import sysconfig
from functools import cache
from importlib.util import source_from_cache
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote, urlsplit

# Size and modification time of a file; None if the file does not exist.
Signature = tuple[int, int] | None
EVENTS = frozenset({"open", "ctypes.dlopen", "sqlite3.connect"})
PYTHON, CACHED, INIT = ".py", ".pyc", "__init__.py"
# Folders of installed packages, and prefixes of other paths that are not data.
INSTALLED = ("site-packages", "dist-packages")
LIBRARY = tuple({sysconfig.get_path(name) + os.sep for name in ("stdlib", "platstdlib")})
SYSTEM = ("/proc/", "/sys/", "/dev/")
ROOT = Path(__file__).parents[1]
OWN = str(ROOT) + os.sep
# Limit on the number of frames of libraries between a plugin and the call that opens a file.
DEEPEST = 24


class Opening(NamedTuple):
    """An opened file, the files of the calling code, innermost first, and whether it was opened for writing only."""

    path: str
    callers: tuple[str, ...]
    written: bool = False


@cache
def openings() -> dict[Opening, Signature]:
    """Return the files opened in this process since the first call, with their sizes and times when opened.

    The first call installs the audit hook.
    """
    heard: dict[Opening, Signature] = {}

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        try:
            opening = _opening(arguments) if event in EVENTS else None
            if opening is not None:
                heard[opening] = signature(opening.path)
        except Exception:
            # An exception would propagate into the code that opens the file. At exit the names of this module no
            # longer exist.
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
    """Return the size and modification time of a file; None if it does not exist."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_size, found.st_mtime_ns


@cache
def home_of(file: Path) -> Path:
    """Return the folder of a module's top-level package (room, in the framework), or the file if in no package."""
    if ROOT in file.parents:
        return ROOT / file.relative_to(ROOT).parts[0]
    if not (file.parent / INIT).is_file():
        return file
    return next(folder for folder in file.parents if not (folder.parent / INIT).is_file())


def is_library(path: str) -> bool:
    """Return whether a path belongs to an installed package or to the standard library."""
    return path.startswith(LIBRARY) or _is_installed(path)


def _is_installed(path: str) -> bool:
    return any(folder in path.split(os.sep) for folder in INSTALLED)


def _path_of(given: Any) -> str | None:
    """Return the absolute path of an opened file; None for descriptors and for databases in memory."""
    if not isinstance(given, str | bytes | os.PathLike):
        return None
    text = os.fsdecode(given)
    if text.startswith("file:"):
        text = unquote(urlsplit(text).path)
    return None if text in {"", ":memory:"} else os.path.abspath(text)


def _callers() -> tuple[str, ...]:
    """Return the files on the call stack up to the framework, without the standard library, innermost first."""
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
