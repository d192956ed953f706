"""Protection of the process from plugin code: its end, its working directory, and the size of its log."""

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import Any, NoReturn, TextIO

# Maximum number of characters that plugins may print at a time.
MOST_PRINTED = 2**20
CUT = "\n[what plugins print is cut here, after a megabyte]\n"


class BoundedText:
    """A text stream that writes at most `most` characters to another stream and discards the rest.

    Other attributes are those of the underlying stream.

    Parameters
    ----------
    stream : text stream
    most : int

    Attributes
    ----------
    stream : text stream
    """

    def __init__(self, stream: TextIO, most: int = MOST_PRINTED) -> None:
        self.stream, self._left = stream, most

    def write(self, text: str) -> int:
        """Write text up to the limit, followed once by a note that the rest is cut."""
        if self._left > 0:
            self.stream.write(text[: self._left])
            if len(text) > self._left:
                self.stream.write(CUT)
            self._left -= len(text)
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write lines, without adding line separators."""
        for line in lines:
            self.write(line)

    def close(self) -> None:
        """Leave the stream open: it is that of the program."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


def unbounded(stream: TextIO) -> TextIO:
    """Return the underlying stream, to which the framework's own messages are written without limit."""
    return unbounded(stream.stream) if isinstance(stream, BoundedText) else stream


@contextmanager
def printed_to_stderr() -> Iterator[None]:
    """Redirect printed text to stderr, up to a megabyte; discard it if the process has no stderr."""
    stream: Any = None if sys.stderr is None else BoundedText(sys.stderr)
    with redirect_stdout(stream), redirect_stderr(stream):
        yield


@contextmanager
def same_folder() -> Iterator[None]:
    """Restore the working directory on exit, because paths given by the user are relative to it."""
    try:
        here = os.getcwd()
    except OSError:
        # The working directory was removed, so it cannot be restored.
        yield
        return
    try:
        yield
    finally:
        with suppress(OSError):
            os.chdir(here)


@contextmanager
def exits_raise() -> Iterator[None]:
    """Let `os._exit` raise SystemExit: a plugin that calls it must not end the program as if it had succeeded."""

    def refuse(status: int) -> NoReturn:
        raise SystemExit(f"os._exit({status})")

    known, os._exit = os._exit, refuse
    try:
        yield
    finally:
        os._exit = known
