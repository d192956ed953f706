"""What the code of plugins may change of a process that loads it: neither its folder nor all of its log."""

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import Any, TextIO

# Letters that plugins may print at a time.
MOST_PRINTED = 2**20
CUT = "\n[what plugins print is cut here, after a megabyte]\n"


class BoundedText:
    """A stream that writes no more than so many letters to another one, and leaves out the rest.

    In all else it is the other one.

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
        """Write what there is room for, and say once that it was not all."""
        if self._left > 0:
            self.stream.write(text[: self._left])
            if len(text) > self._left:
                self.stream.write(CUT)
            self._left -= len(text)
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write lines, which end as they are."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


def unbounded(stream: TextIO) -> TextIO:
    """Return the stream that is written to in the end: what the program itself says has no bound."""
    return unbounded(stream.stream) if isinstance(stream, BoundedText) else stream


@contextmanager
def printed_to_stderr() -> Iterator[None]:
    """Send to stderr what is printed, up to a megabyte; nowhere where the program was started without it."""
    stream: Any = None if sys.stderr is None else BoundedText(sys.stderr)
    with redirect_stdout(stream), redirect_stderr(stream):
        yield


@contextmanager
def same_folder() -> Iterator[None]:
    """Come back to the folder that the process is in: paths that the user has named are relative to it."""
    try:
        here = os.getcwd()
    except OSError:
        # It was removed: there is none to come back to.
        yield
        return
    try:
        yield
    finally:
        with suppress(OSError):
            os.chdir(here)
