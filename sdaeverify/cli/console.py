"""Output streams: results on stdout; errors, warnings and progress on stderr, one line each."""

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
# Longest message in characters.
LONGEST = 1600


def complain(kind: str, message: str) -> None:
    """Write a message as one line to stderr.

    Parameters
    ----------
    kind : str
        ``error``, ``warning``, or empty for no label.
    message : str
        Text of the message; line breaks and control characters are escaped.
    """
    style = {"error": "bold red", "warning": "yellow"}.get(kind, "")
    label = f"{kind}: " if kind else ""
    line = Text.assemble(f"{PROGRAM}: ", (label, style), _shorten(visible(" ".join(message.split()))))
    errors().print(line, soft_wrap=True)


def _shorten(text: str) -> str:
    """Omit the middle of a long text, because quoted input may have any length."""
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 4 :]}"


@contextmanager
def output_to_stderr() -> Iterator[None]:
    """Redirect stdout to stderr at the level of file descriptors.

    Output printed by the code of a plugin must not be mixed with results.
    """
    with printed_to_stderr():
        if sys.__stdout__ is None or sys.__stderr__ is None:
            # The program was started with a stream closed, so that its descriptor may belong to another file.
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
    """Print texts on separate lines; unprintable characters are escaped, except in styled texts."""
    for text in texts:
        console.print(Text(visible(text)) if isinstance(text, str) else text, soft_wrap=True)


def print_json(value: object) -> None:
    """Print a value as JSON on stdout."""
    click.echo(json.dumps(value, indent=2))


def conclude(code: ExitCode, seconds: float | None = None) -> ExitCode:
    """Print the exit code with its meaning, optionally with the elapsed time, and return it.

    Parameters
    ----------
    code : ExitCode
    seconds : float, optional
        Elapsed time in seconds; omitted if None.
    """
    taken = "" if seconds is None else f"{seconds:.0f} s; "
    style = "green" if code is ExitCode.OK else "red"
    output().print(f"{taken}exit code {code.value}: {code.words}", style=style, soft_wrap=True)
    return code
