"""Programs as plugins without a plugin file: the option ``--wire`` and the table ``[tool.sdaeverify.wire]``.

The text is a command, or an address, behind words that are for this package::

    patience=5 name=my-milstein ./my_solver --theta 0.5
"""

import re
import shlex
from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

from sdaeverify import Scheme, UsageError, hookimpl
from sdaeverify.commands import PluginSource

from .calling import split_command
from .scheme import PATIENCE, scheme_of

# Words before the command.
OWN = re.compile(r"(name|patience)=(.*)", re.DOTALL)
KEYS = ("command", "patience")


class Given(NamedTuple):
    """A program as its user names it.

    Attributes
    ----------
    command : tuple of str
        From `split_command`.
    patience : float
        Seconds without any byte after which the program counts as hung.
    name : str
        Name that the program must have in its hello; empty for any.
    """

    command: tuple[str, ...]
    patience: float = PATIENCE
    name: str = ""

    @property
    def text(self) -> str:
        """The text that is read as this program."""
        patience = [] if self.patience == PATIENCE else [f"patience={self.patience:g}"]
        return shlex.join([*patience, *([f"name={self.name}"] if self.name else []), *self.command])


def read_given(text: str, folder: Path) -> Given:
    """Return the program that a text names.

    Parameters
    ----------
    text : str
    folder : Path
        Folder of relative paths.

    Raises
    ------
    UsageError
        If it is malformed, or there is no such program.
    """
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise UsageError(f"cannot read {text!r:.200} as a program with its arguments: {error}") from None
    own: dict[str, Any] = {}
    while words and (match := OWN.fullmatch(words[0])):
        own[match[1]], words = match[2], words[1:]
    if not words:
        raise UsageError(f"cannot read {text!r:.200} as a program with its arguments: it names no program")
    if "patience" in own:
        own["patience"] = _seconds(own["patience"])
    return Given(split_command(words, folder), **own)


def _seconds(given: object) -> float:
    try:
        seconds = float(given) if isinstance(given, str | int | float) and not isinstance(given, bool) else 0.0
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < inf:
        raise UsageError(f"patience of a program expects a number of seconds, got {given!r:.60}")
    return seconds


def absolute(text: str, folder: Path) -> str:
    """Return the text of a program that means the same in any current folder."""
    return read_given(text, folder).text


def plugin(text: str) -> object:
    """Start a program, read its hello, and return a plugin with its scheme."""
    given = read_given(text, Path.cwd())
    scheme = scheme_of(given.command, given.patience)
    if given.name not in {"", scheme.name}:
        raise UsageError(f"{shlex.join(given.command)}: its hello names it {scheme.name!r}, expected {given.name!r}")

    @hookimpl
    def sdaeverify_schemes() -> list[Scheme]:
        return [scheme]

    return SimpleNamespace(sdaeverify_schemes=sdaeverify_schemes)


def texts(table: object) -> Sequence[str]:
    """Return the texts of a table of a policy: its keys are names of schemes, its values commands."""
    if not isinstance(table, Mapping):
        raise UsageError(f"wire expects a table of names and commands, got {table!r:.80}")
    return [_text(name, value) for name, value in table.items()]


def _text(name: str, value: object) -> str:
    given = value if isinstance(value, Mapping) else {"command": value}
    if unknown := sorted(set(given) - set(KEYS)):
        raise UsageError(f"wire.{name}: unknown key {unknown[0]!r:.60}, expected {' and '.join(KEYS)}")
    command = given.get("command")
    words = _split(name, command) if isinstance(command, str) else command
    if not words or not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise UsageError(f"wire.{name} expects a command, a text or a list of texts, got {command!r:.80}")
    if isinstance(patience := given.get("patience", PATIENCE), str):
        raise UsageError(f"wire.{name}: patience expects a number of seconds, got {patience!r:.60}")
    return Given(tuple(words), _seconds(patience), name).text


def _split(name: str, command: str) -> list[str]:
    try:
        return shlex.split(command)
    except ValueError as error:
        raise UsageError(f"wire.{name}: cannot read {command!r:.80} as a command: {error}") from None


WIRE = PluginSource(
    "COMMAND", "Program or address that speaks the wire protocol, as a scheme.", absolute, plugin, texts
)
