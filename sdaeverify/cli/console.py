"""Where words go: results to stdout; errors, warnings and progress to stderr, one line each."""

import json
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress

import click
from rich.console import Console
from rich.text import Text

from ..registry.foreign_code import printed_to_stderr
from ..report.plain import errors, output, silence, visible
from .exit_codes import ExitCode

__all__ = ["complain", "conclude", "errors", "output", "output_to_stderr", "print_json", "print_texts", "silence"]

PROGRAM = "sdaeverify"
STDOUT, STDERR = 1, 2
# Letters of a message.
LONGEST = 1600


def complain(kind: str, message: str) -> None:
    """Write one line to stderr.

    Parameters
    ----------
    kind : str
        ``error``, ``warning``, or empty for neither.
    message : str
        Anything; what cannot be shown on one line is escaped.
    """
    style = {"error": "bold red", "warning": "yellow"}.get(kind, "")
    label = f"{kind}: " if kind else ""
    line = Text.assemble(f"{PROGRAM}: ", (label, style), _shorten(visible(" ".join(message.split()))))
    errors().print(line, soft_wrap=True)


def _shorten(text: str) -> str:
    """Return a text whose middle is left out where nobody would read it: what it quotes may have any length."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 4 :]}"


@contextmanager
def output_to_stderr() -> Iterator[None]:
    """Send to stderr what is written to stdout, even past Python: what the code of a plugin prints is no result."""
    with printed_to_stderr():
        if sys.__stdout__ is None or sys.__stderr__ is None:
            # The program was started without: what has their number now is some other file.
            yield
            return
        sys.__stdout__.flush()
        kept = os.dup(STDOUT)
        os.dup2(STDERR, STDOUT)
        try:
            yield
        finally:
            with suppress(OSError, ValueError):
                sys.__stdout__.flush()
            os.dup2(kept, STDOUT)
            os.close(kept)


def print_texts(console: Console, texts: Iterable[str | Text]) -> None:
    """Print texts, each on a line of its own; what cannot be shown is escaped, but for texts with a style."""
    for text in texts:
        console.print(Text(visible(text)) if isinstance(text, str) else text, soft_wrap=True)


def print_json(value: object) -> None:
    """Print a value for programs."""
    click.echo(json.dumps(value, indent=2))


def conclude(code: ExitCode, seconds: float | None = None) -> ExitCode:
    """Print the meaning of the code of a command, with the seconds that it took if they are given, and return it.

    Parameters
    ----------
    code : ExitCode
    seconds : float, optional
        What it took; nothing is said of it if left out.
    """
    taken = "" if seconds is None else f"{seconds:.0f} s; "
    style = "green" if code is ExitCode.OK else "red"
    output().print(f"{taken}exit code {code.value}: {code.words}", style=style, soft_wrap=True)
    return code
