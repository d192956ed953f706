"""Which files the code of a cell has opened, and what they hold: evidence holds as long as they do.

Files below a package or beside a plugin file are told by where they are in it, so that another machine finds its own.
"""

import hashlib
import os
import stat
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from ..contracts.opened import Caller, Opening, Signature, is_library, openings, owners, signature
from .behaviour import CHANGED
from .code import Code, home_of
from .statements import parse_statements

# Paths with hashes of what the files hold.
Opened = tuple[tuple[str, str], ...]
MISSING, MIXED, OTHER = "not there", "saved while it was read", "no file"
# Code of which it cannot be told what it opened: this never holds again.
UNKNOWN: Opened = (("code that was saved since it was imported", MIXED),)
# Bytes of a file that is read; of a longer one, its size and time count.
LARGEST = 2**24
# What the functions are called that register plugins: what they open may go into anything.
HOOK = "sdaeverify_"


def data_opened(things: Iterable[Any]) -> list[tuple[Opening, Signature]]:
    """Return what may be data of some classes and functions, with size and time, without reading their code.

    Parameters
    ----------
    things : iterable of type or callable
        What no code of them, or of others that are installed nowhere, has opened is left out; so are modules of
        the packages that asked for them.
    """
    modules = {sys.modules.get(getattr(thing, "__module__", "")) for thing in things}
    files = [Path(file) for module in modules if (file := getattr(module, "__file__", None))]
    owners().update(str(home_of(file)) for file in files)
    return [(opening, was) for opening, was in openings() if _is_plugins(opening) and not _is_own_module(opening)]


def _is_plugins(opening: Opening) -> bool:
    return any(_home(caller.file) or not is_library(caller.file) for caller in opening.callers)


def opened_by(codes: Sequence[Code | None]) -> Opened:
    """Return the files that code has opened in this process so far, but not those it has written itself.

    Parameters
    ----------
    codes : sequence of (Code or None)
        Of a scheme, a problem and measures.
    """
    known = [code for code in codes if code is not None]
    if len(known) < len(codes):
        return UNKNOWN
    own = [(opening, was) for opening, was in openings() if _is_reached(opening.callers, known)]
    written = {opening.path for opening, _ in own if opening.written}
    homes = [home for code in known for home in code.homes]
    # Of a file that was opened more than once, what was mixed at any time counts.
    found = {
        _told(opening.path, homes): digest_of_file(opening.path) if was == signature(opening.path) else MIXED
        for opening, was in sorted(own, key=lambda pair: pair[1] == signature(pair[0].path), reverse=True)
        if opening.path not in written and not _is_code(opening.path, homes)
    }
    return tuple(sorted((path, held) for path, held in found.items() if held != OTHER))


def differing_files(opened: Opened, codes: Iterable[Code | None]) -> list[str]:
    """Return the names of the files that hold something else now.

    Parameters
    ----------
    opened : tuple of (str, str)
        As `opened_by` returned it, perhaps elsewhere.
    codes : iterable of (Code or None)
        The same code here.
    """
    homes = [home for code in codes if code is not None for home in code.homes]
    return [Path(path).name for path, held in opened if digest_of_file(_place(path, homes)) != held]


def saved_between(one: Opened, other: Opened) -> str:
    """Return in one line which file held two things in evidence of the same run; empty if none did."""
    before = dict(one)
    words = {MISSING, MIXED, OTHER}
    names = [Path(path).name for path, held in other if len({before.get(path, held), held} - words) > 1]
    return f"{names[0]} {CHANGED}" if names else ""


def _is_own_module(opening: Opening) -> bool:
    if not opening.path.endswith(".py"):
        return False
    asking = [caller.file for caller in opening.callers if not is_library(caller.file)]
    return not asking or home_of(Path(opening.path)) in {home_of(Path(file)) for file in asking}


def _is_reached(callers: Sequence[Caller], codes: Sequence[Code]) -> bool:
    """Tell whether who opened a file is part of some code: the innermost code of a plugin did it."""
    ours = [caller for caller in callers if _home(caller.file)]
    if not ours:
        return False
    registering = {_home(caller.file) for caller in ours if caller.name.startswith(HOOK)}
    return any(code.reaches(ours[0]) or bool(registering & set(map(str, code.homes))) for code in codes)


def _home(file: str) -> str:
    """Return the home of a plugin that a file is in, the innermost one; empty if it is in none that is known."""
    # Homes are never forgotten, so that their number tells which are known.
    return _nearest_home(file, len(owners()))


@lru_cache(maxsize=2**14)
def _nearest_home(file: str, known: int) -> str:  # noqa: ARG001 - see `_home`
    folder, homes = file, owners()
    while folder not in homes and folder != (above := os.path.dirname(folder)):
        folder = above
    return folder if folder in homes else ""


def _is_code(path: str, homes: Iterable[Path]) -> bool:
    """Tell whether a file is of parsed code, which counts by itself."""
    return path.endswith(".py") and any(Path(path) == home or home in Path(path).parents for home in homes)


def _folders(homes: Iterable[Path]) -> Iterator[tuple[str, Path]]:
    """Yield what stands for a folder in a path that is told, and the folder."""
    yield from ((f"<{home.name}>", home.parent if home.suffix else home) for home in homes)


def _told(path: str, homes: Iterable[Path]) -> str:
    found = ((name, folder) for name, folder in _folders(homes) if folder in Path(path).parents)
    return next((f"{name}/{Path(path).relative_to(folder).as_posix()}" for name, folder in found), path)


def _place(told: str, homes: Iterable[Path]) -> str:
    first, _, rest = told.partition("/")
    return next((str(folder / rest) for name, folder in _folders(homes) if name == first), told)


def digest_of_file(path: str) -> str:
    """Return a hash of what a file holds, of a module of what is parsed; a word where there is no such file."""
    return _read(path, signature(path))


@cache
def _read(path: str, found: Signature) -> str:
    try:
        if found is None:
            return MISSING
        if not stat.S_ISREG(os.stat(path).st_mode):
            return OTHER
        if found[0] > LARGEST:
            return repr(found)
        content = Path(path).read_bytes()
    except OSError:
        return MISSING
    return hashlib.blake2b(_parsed(path, content), digest_size=12).hexdigest()


def _parsed(path: str, content: bytes) -> bytes:
    if not path.endswith(".py"):
        return content
    try:
        return b"\0".join(one.content for one in parse_statements(Path(path), "", content, frozenset()))
    except (SyntaxError, ValueError):
        return content
