"""Commands and addresses of programs: how a user writes them, what they depend on, and the connection to one."""

import hashlib
import os
import shlex
import shutil
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from sdaeverify import UsageError

from .address import EXPECTED, TCP, UNIX, Address, absolute_address
from .connection import Connection
from .program import Program

Command = str | Path | Sequence[str]
# Largest size in bytes of a file that is hashed; for a longer one, size and modification time are compared.
LARGEST = 2**26


class Calling(NamedTuple):
    """How a program is called.

    Attributes
    ----------
    command : tuple of str
        From `split_command`.
    patience : float
        Seconds without any byte after which the program counts as hung.
    build : str or None
        Hash of the contents of the program and its arguments; None if they are unknown, as for an address.
    """

    command: tuple[str, ...]
    patience: float
    build: str | None

    @classmethod
    def of(cls, command: Command, patience: float, folder: Path | None = None) -> "Calling":
        """Return how a program is called.

        Parameters
        ----------
        command, folder
            As for `split_command`.
        patience : float
        """
        words = split_command(command, folder)
        return cls(words, patience, digest_of(words))

    def connect(self) -> Connection:
        """Start the program, or connect to it if it listens on an address.

        Raises
        ------
        SchemeError
            If it cannot be started or reached, or has changed.
        """
        if self.command[0].startswith((UNIX, TCP)):
            return Address(self.command[0], self.patience)
        program = Program(self.command, self.patience)
        if digest_of(self.command) != self.build:
            raise program.failure("was changed since it was registered; run it again")
        return program


def split_command(command: Command, folder: Path | None = None) -> tuple[str, ...]:
    """Return the words of a command, independent of the current folder, or an address as its only word.

    The program becomes an absolute path. So does each argument with a dot or a slash that names an existing file.

    Parameters
    ----------
    command : str, Path or sequence of str
        Command or address; a text is split as by a shell, a path is a program without arguments.
    folder : Path, optional
        Folder of relative paths; by default the current one.

    Raises
    ------
    UsageError
        If `command` is malformed, or there is no such program.
    """
    try:
        words = _words(command)
        if not words:
            raise ValueError("it is empty")
        found = shutil.which(os.path.join(folder or "", words[0]) if os.sep in words[0] else words[0])
    except (TypeError, ValueError) as error:
        raise UsageError(f"cannot read {command!r:.200} as a program with its arguments: {error}") from None
    if words[0].startswith((UNIX, TCP)):
        return absolute_address(words, folder or Path())
    if found is None:
        raise UsageError(f"no program {words[0]!r:.200} that can be run: {_why_no_program(words[0], folder)}")
    return (os.path.abspath(found), *(_absolute_file(word, folder) for word in words[1:]))


def _words(command: Command) -> list[str]:
    if isinstance(command, str):
        return shlex.split(command)
    return [os.fspath(word) for word in ([command] if isinstance(command, Path) else command)]


def _why_no_program(word: str, folder: Path | None) -> str:
    """Return why a word names no program."""
    file = os.path.join(folder or "", word)
    if os.path.isfile(file):
        given = "" if os.access(file, os.X_OK) else f"; the file is not executable: chmod +x {shlex.quote(word)}"
        return f"expected a path with a slash, such as ./{word}" if os.sep not in word else given.removeprefix("; ")
    return EXPECTED if ":" in word else "expected a path, or a name in PATH"


def _absolute_file(word: str, folder: Path | None) -> str:
    file = os.path.join(folder or "", word)
    return os.path.abspath(file) if {".", os.sep} & {*word} and os.path.isfile(file) else word


def digest_of(command: tuple[str, ...]) -> str | None:
    """Return a hash of the contents of a program and of its arguments; None for an address.

    An argument that names a file counts by its content. Files that the program opens by itself do not count.

    Parameters
    ----------
    command : tuple of str
        From `split_command`.
    """
    if command[0].startswith((UNIX, TCP)):
        return None
    found = hashlib.blake2b(digest_size=12)
    for word in command:
        found.update(_content(word) + b"\0")
    return found.hexdigest()


def _content(word: str) -> bytes:
    try:
        known = os.stat(word) if os.path.isfile(word) else None
        return word.encode() if known is None else _digest_of_file(word, known.st_size, known.st_mtime_ns)
    except OSError:
        return b"not readable"


@lru_cache(maxsize=64)
def _digest_of_file(path: str, size: int, modified: int) -> bytes:
    content = Path(path).read_bytes() if size <= LARGEST else f"{size} {modified}".encode()
    return hashlib.blake2b(content, digest_size=12).digest()
