"""The consoles of the program: results go to stdout; errors, warnings and progress go to stderr."""

import os
import sys
from typing import IO

from rich.console import Console

from ..registry.foreign_code import unbounded

# Wider than any table: a line that is piped into another program is not broken.
UNBROKEN = 10_000


class _Output(Console):
    """A console that ends quietly where nobody reads on."""

    def on_broken_pipe(self) -> None:
        self.quiet = True
        silence(self.file)


def output(*, unbroken: bool = False) -> Console:
    """Return the console on stdout: plain text where it is no terminal or ``NO_COLOR`` is set.

    Parameters
    ----------
    unbroken : bool
        Whether a table may be wider than 80 columns where it is no terminal.
    """
    console = _Output(highlight=False, markup=False, emoji=False)
    if unbroken and not console.is_terminal:
        console.width = UNBROKEN
    return console


def errors() -> Console:
    """Return the console on stderr."""
    file = None if sys.stderr is None else unbounded(sys.stderr)
    return _Output(file=file, stderr=True, highlight=False, markup=False, emoji=False)


def silence(stream: IO[str]) -> None:
    """Let whatever is still written to a stream vanish, at the end of the process too."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
