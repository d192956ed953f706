"""How a worker process marks whose code it runs, and until when that may: what is left of it when it dies."""

import mmap
import struct
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import NamedTuple

from ..errors import FAULTS, SdaeverifyError
from ..simulate.ensemble import NO_MEASURE, PROBLEM, Marker, alone

NOBODY = PROBLEM - 1
FORMAT = struct.Struct("<qqd")


class Mark(NamedTuple):
    """Whose code a worker runs: what is left of it when it dies.

    Attributes
    ----------
    scheme : int
        Index of the scheme, `PROBLEM`, or `NOBODY`.
    measure : int
        Index of the measure or `NO_MEASURE`.
    deadline : float
        Of the monotonic clock, from which on the process may be ended.
    """

    scheme: int = NOBODY
    measure: int = NO_MEASURE
    deadline: float = inf


class StopError(SdaeverifyError):
    """Code that is watched raised what is meant to end a program, such as KeyboardInterrupt."""


def read_mark(path: Path) -> Mark:
    """Return the mark in a file; nobody's if there is none."""
    data = path.read_bytes() if path.is_file() else b""
    return Mark(*FORMAT.unpack(data)) if len(data) == FORMAT.size else Mark()


class Watchdog(Marker):
    """Marks in a file whose code runs, and until when it may: who waits for the call ends the process after that.

    Nothing here keeps the time: code that never comes back, ignores signals or turns off alarms would not let it.

    Parameters
    ----------
    path : Path
        Of the mark.
    timeout : float
        Seconds for each scheme, and for the problem.
    """

    def __init__(self, path: Path, timeout: float) -> None:
        path.write_bytes(FORMAT.pack(*Mark()))
        with path.open("r+b") as file:
            self.memory = mmap.mmap(file.fileno(), FORMAT.size)
        self.timeout, self.mark = timeout, Mark()
        self.spent: dict[int, float] = defaultdict(float)

    @contextmanager
    def of(self, scheme: int) -> Iterator[None]:
        """Run code of a scheme or of the problem against its time."""
        begun = time.monotonic()
        left = max(self.timeout - self.spent[scheme], 1e-3)
        self._write(Mark(scheme, NO_MEASURE, begun + left))
        try:
            with self._alive():
                yield
        finally:
            self.spent[scheme] += time.monotonic() - begun
            self._write(Mark())

    @contextmanager
    def measure(self, index: int) -> Iterator[None]:
        """Note that it is a measure that runs."""
        before = self.mark
        self._write(before._replace(measure=index))
        try:
            with self._alive():
                yield
        finally:
            self._write(before)

    @contextmanager
    def _alive(self) -> Iterator[None]:
        try:
            with alone():
                yield
        except FAULTS:
            raise
        except BaseException as error:
            # Workers hear no interrupt of the user's: whatever ends a program is the plugin's own.
            raise StopError(f"{type(error).__name__}: raised by the plugin") from error

    def _write(self, mark: Mark) -> None:
        self.mark = mark
        self.memory[:] = FORMAT.pack(*mark)
