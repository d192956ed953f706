"""Which files code opens in this process, and whose code that is: an audit hook of the interpreter tells.

A file counts for whoever runs the definition that opened it, also where a process opens it once and keeps what it
read. What the framework opens for itself, and code of installed libraries, is left out. An audit hook hears nothing
of what a library opens in C, and nothing of other processes.
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
PYTHON, CACHED = ".py", ".pyc"
# Folders of installed packages, and what begins the paths of others that are no data.
INSTALLED = ("site-packages", "dist-packages")
LIBRARY = tuple({sysconfig.get_path(name) + os.sep for name in ("stdlib", "platstdlib")})
SYSTEM = ("/proc/", "/sys/", "/dev/")
OWN = str(Path(__file__).parents[1]) + os.sep
IMPORTING = "<frozen importlib._bootstrap_external>"
# Frames of a library that may lie between a plugin and what it opens.
DEEPEST = 24
CHANGED = (-1, -1)


class Caller(NamedTuple):
    """Code that was running: its file, and the definition at the top of that, such as a class."""

    file: str
    name: str


class Opening(NamedTuple):
    """A file that was opened, the code that did it, innermost first, and whether it was only written."""

    path: str
    callers: tuple[Caller, ...]
    written: bool = False


class _Seen(NamedTuple):
    signature: Signature
    block: int


class _Record:
    """What was opened so far in this process."""

    def __init__(self) -> None:
        self.block = 0
        self.openings: dict[Opening, _Seen] = {}
        self.imported: dict[str, Signature] = {}
        self.owners: set[str] = set()

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event; an error here would be one of the code that is listened to."""
        if event in EVENTS:
            try:
                self._note(arguments)
            except Exception:
                return

    def _note(self, arguments: tuple[Any, ...]) -> None:
        path = _path_of(arguments[0])
        if path is None or path.startswith(SYSTEM):
            return
        if path.endswith((PYTHON, CACHED)):
            if is_library(path) or path.startswith(OWN):
                return
            path = source_from_cache(path) if path.endswith(CACHED) else path
            if sys._getframe(2).f_code.co_filename == IMPORTING:
                self.imported[path] = signature(path)
        mode = arguments[2] if len(arguments) > 2 and isinstance(arguments[2], int) else os.O_RDONLY
        if callers := _callers():
            written = bool(mode & (os.O_TRUNC | os.O_EXCL)) or mode & os.O_ACCMODE == os.O_WRONLY
            self._add(Opening(path, callers, written))

    def _add(self, opening: Opening) -> None:
        now, before = signature(opening.path), self.openings.get(opening)
        if before is None or before.block != self.block:
            self.openings[opening] = _Seen(now, self.block)
        elif before.signature != now:
            self.openings[opening] = _Seen(CHANGED, self.block)


@cache
def record() -> _Record:
    """Return what was opened in this process since this was first called."""
    kept = _Record()
    sys.addaudithook(kept.hear)
    return kept


def owners() -> set[str]:
    """Return the folders and files of code that evidence is about, as far as they are known so far."""
    return record().owners


def begin_block() -> None:
    """Note that a file which changed since it was opened may be opened anew: what changes from now on is mixed."""
    record().block += 1


def openings() -> list[tuple[Opening, Signature]]:
    """Return what was opened, with size and time of each file when it was."""
    return [(opening, seen.signature) for opening, seen in list(record().openings.items())]


def saved_since_import(path: Path) -> bool:
    """Tell whether a module that this process has imported was saved afterwards: what it holds is not what runs."""
    known = record().imported
    return str(path) in known and known[str(path)] != signature(str(path))


def signature(path: str) -> Signature:
    """Return size and time of a file; None if it is not there."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_size, found.st_mtime_ns


@cache
def is_library(path: str) -> bool:
    """Tell whether a path is that of an installed package or of the standard library."""
    return path.startswith(LIBRARY) or any(folder in path.split(os.sep) for folder in INSTALLED)


@cache
def _is_standard(path: str) -> bool:
    return path.startswith(LIBRARY) and not any(folder in path.split(os.sep) for folder in INSTALLED)


def _path_of(given: Any) -> str | None:
    """Return the absolute path of what is opened; None of a descriptor and of what is no file."""
    if not isinstance(given, str | bytes | os.PathLike):
        return None
    text = os.fsdecode(given)
    if text.startswith("file:"):
        text = unquote(urlsplit(text).path)
    return None if text in {"", ":memory:"} else os.path.abspath(text)


def _callers() -> tuple[Caller, ...]:
    """Return the code that runs, up to the framework that called it, without the standard library and texts."""
    found: list[Caller] = []
    # The hook's own two frames.
    frame = sys._getframe(1)
    while frame.f_code.co_filename == __file__ and frame.f_back is not None:
        frame = frame.f_back
    while len(found) < DEEPEST and not frame.f_code.co_filename.startswith(OWN):
        code = frame.f_code
        if not (code.co_filename.startswith("<") or _is_standard(code.co_filename)):
            caller = Caller(code.co_filename, code.co_qualname.partition(".")[0])
            found += [caller] if found[-1:] != [caller] else []
        if frame.f_back is None:
            break
        frame = frame.f_back
    return tuple(found)
