"""Files that the code of evidence has opened, with their hashes: evidence is valid as long as they are unchanged.

The path of a file in a package, or in the folder of a plugin file, is stored relative to it, so that another machine
finds its own copy.
"""

import hashlib
import os
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..contracts.opened import Opening, home_of, openings, signature
from .code import parsed_file

# Paths with hashes of the contents.
Opened = tuple[tuple[str, str], ...]
MISSING, MIXED = "not there", "saved while it was read"
# Largest size in bytes of a file that is hashed; for a longer one, size and modification time are compared.
LARGEST = 2**24


def opened_by(homes: Iterable[Path]) -> Opened:
    """Return the files that code has opened in this process so far, except those that it has written itself.

    Parameters
    ----------
    homes : iterable of Path
        The top-level packages and single files of the code.
    """
    known, recorded = frozenset(homes), list(openings().items())
    code = {file for opening, _ in recorded for file in opening.callers}
    code = {file for file in code if home_of(Path(file)) in known}
    written = {opening.path for opening, _ in recorded if opening.written and not code.isdisjoint(opening.callers)}
    read = [(o, was) for o, was in recorded if not o.written and o.path not in written and _counts(o, code, known)]
    own = [(opening.path, was) for opening, was in read if _is_file(opening.path)]
    found = {_portable_path(path, known): digest_of_file(path) for path, _ in own}
    # If a file was opened more than once, a change between any of these times counts.
    mixed = {_portable_path(path, known): MIXED for path, was in own if was != signature(path)}
    return tuple(sorted({**found, **mixed}.items()))


def differing_files(opened: Opened, homes: Iterable[Path]) -> list[str]:
    """Return the names of the files whose content has changed.

    Parameters
    ----------
    opened : tuple of (str, str)
        From `opened_by`, possibly on another machine.
    homes : iterable of Path
        The packages and files of the same code on this machine.
    """
    known = frozenset(homes)
    return [Path(path).name for path, held in opened if digest_of_file(_local_path(path, known)) != held]


def digest_of_file(path: str) -> str:
    """Return a hash of a file's content, of the parsed code for a module; `MISSING` if it cannot be read.

    For a file larger than `LARGEST`, return its size and modification time.
    """
    found = signature(path)
    if found is not None and found[0] > LARGEST:
        return repr(found)
    try:
        content = Path(path).read_bytes() if _is_file(path) else None
    except OSError:
        content = None
    if content is None:
        return MISSING
    return hashlib.blake2b(parsed_file(content) if path.endswith(".py") else content, digest_size=12).hexdigest()


def _is_file(path: str) -> bool:
    """Return whether `path` is a regular file or does not exist.

    Other kinds of files (pipes, devices) are excluded because reading them may block.
    """
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except OSError:
        return True


def _counts(opening: Opening, code: set[str], homes: frozenset[Path]) -> bool:
    """Return whether evidence depends on an opened file: the code opened it, or may have imported it as a module."""
    module = opening.path.endswith(".py")
    if module and home_of(Path(opening.path)) in homes:
        return False
    return not code.isdisjoint(opening.callers) or (module and _lies_beside(Path(opening.path), homes))


def _lies_beside(module: Path, homes: frozenset[Path]) -> bool:
    """Return whether a module in no package is in the folder that contains a package or plugin file of `homes`."""
    return home_of(module) == module and module.parent in {home.parent for home in homes}


def _folders(homes: Iterable[Path]) -> Iterator[tuple[str, Path]]:
    """Yield the placeholder of each folder in stored paths, and the folder."""
    yield from ((f"<{home.name}>", home.parent if home.suffix else home) for home in sorted(homes))


def _portable_path(path: str, homes: Iterable[Path]) -> str:
    found = ((name, folder) for name, folder in _folders(homes) if folder in Path(path).parents)
    return next((f"{name}/{Path(path).relative_to(folder).as_posix()}" for name, folder in found), path)


def _local_path(path: str, homes: Iterable[Path]) -> str:
    first, _, rest = path.partition("/")
    return next((str(folder / rest) for name, folder in _folders(homes) if name == first), path)
