"""Marks in a file of whose code a worker runs and its deadline: they remain readable if the worker dies."""

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
    """The scheme and measure whose code a worker runs, and its deadline.

    Attributes
    ----------
    scheme : int
        Index of the scheme, `PROBLEM` for the problem, or `NOBODY` if no plugin code runs.
    measure : int
        Index of the measure or `NO_MEASURE`.
    deadline : float
        Time of the monotonic clock after which the parent may end the process.
    """

    scheme: int = NOBODY
    measure: int = NO_MEASURE
    deadline: float = inf


class StopError(SdaeverifyError):
    """Plugin code raised an exception that ends a program, such as KeyboardInterrupt."""


def read_mark(path: Path) -> Mark:
    """Return the mark in a file, or an empty mark if there is no complete one."""
    data = path.read_bytes() if path.is_file() else b""
    return Mark(*FORMAT.unpack(data)) if len(data) == FORMAT.size else Mark()


class Watchdog(Marker):
    """A marker that writes whose code runs and its deadline to a file.

    The parent process, which waits for the call, ends the worker after the deadline. A timer in the worker would not
    do: code that never returns, ignores signals or disables alarms would not let it run.

    Parameters
    ----------
    path : Path
        File of the mark.
    timeout : float
        Seconds for each scheme, and for the problem, in this call.
    """

    def __init__(self, path: Path, timeout: float) -> None:
        path.write_bytes(FORMAT.pack(*Mark()))
        with path.open("r+b") as file:
            self.memory = mmap.mmap(file.fileno(), FORMAT.size)
        self.timeout, self.mark = timeout, Mark()
        self.spent: dict[int, float] = defaultdict(float)

    @contextmanager
    def of(self, scheme: int) -> Iterator[None]:
        """Mark the code of a scheme, or of the problem, with the rest of its time."""
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
        """Mark that a measure of the current scheme runs."""
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
            # Workers ignore interrupts of the user, so an exception that ends a program comes from the plugin.
            raise StopError(f"{type(error).__name__}: raised by the plugin") from error

    def _write(self, mark: Mark) -> None:
        self.mark = mark
        self.memory[:] = FORMAT.pack(*mark)
