"""What a scheme may take on one block of paths, and how a worker process marks what it has taken."""

import mmap
import os
import struct
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import NamedTuple

from ..errors import FAULTS, SdaeverifyError, UsageError
from ..simulate.marker import NO_MEASURE, PROBLEM, Marker, alone

NOBODY = PROBLEM - 1
FORMAT = struct.Struct("<qqd")


@dataclass(frozen=True)
class Limits:
    """Limits of a worker process.

    Attributes
    ----------
    timeout : float
        Seconds that the code of one scheme may take on one block; infinite for no limit.
    memory : int
        Bytes of address space beyond what a worker starts with; 0 for no limit.

    Raises
    ------
    UsageError
        If the platform has no such limits.
    """

    timeout: float = inf
    memory: int = 0

    def __post_init__(self) -> None:
        if not self.timeout > 0.0:
            raise UsageError(f"timeout must be a positive number of seconds, got {self.timeout:g}")
        if self.memory and not _has_resource():
            raise UsageError("this platform cannot limit the memory of a process; leave out --memory")


class Mark(NamedTuple):
    """Whose code a worker runs: what is left of it when it dies.

    Attributes
    ----------
    lane : int
        Index of the scheme, `marker.PROBLEM`, or `NOBODY`.
    measure : int
        Index of the measure or `marker.NO_MEASURE`.
    deadline : float
        Of the monotonic clock, from which on the process may be ended.
    """

    lane: int = NOBODY
    measure: int = NO_MEASURE
    deadline: float = inf

    def timed_out(self, when: float) -> bool:
        """Tell whether a process that died at a time of the monotonic clock had run out of its own."""
        return when >= self.deadline


class StopError(SdaeverifyError):
    """Code that is watched raised what is meant to end a program, such as KeyboardInterrupt.

    Parameters
    ----------
    reason : str
    lane : int
        Whose code it was, as in `Mark`.
    """

    def __init__(self, reason: str, lane: int = NOBODY) -> None:
        super().__init__(reason)
        self.lane = lane


def read_mark(path: Path) -> Mark:
    """Return the mark in a file."""
    data = path.read_bytes()
    return Mark(*FORMAT.unpack(data)) if len(data) == FORMAT.size else Mark()


class Watchdog(Marker):
    """Marks in a file whose code runs, and until when it may: a `Timekeeper` ends the process after that.

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
    def of(self, lane: int) -> Iterator[None]:
        """Run code of a scheme or of the problem against its time."""
        begun = time.monotonic()
        left = max(self.timeout - self.spent[lane], 1e-3)
        self._write(Mark(lane, NO_MEASURE, begun + left))
        try:
            with self._alive():
                yield
        finally:
            self.spent[lane] += time.monotonic() - begun
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
            raise StopError(f"{type(error).__name__}: raised by the plugin", self.mark.lane) from error

    def _write(self, mark: Mark) -> None:
        self.mark = mark
        self.memory[:] = FORMAT.pack(*mark)


def limit_memory(extra: int) -> None:
    """Let this process have so many bytes of address space beyond what it has."""
    if extra:
        import resource  # noqa: PLC0415 - not on every platform

        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        wanted = _address_space() + extra
        resource.setrlimit(resource.RLIMIT_AS, (wanted if hard < 0 else min(wanted, hard), hard))


def _address_space() -> int:
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE") if statm.is_file() else 0


def _has_resource() -> bool:
    try:
        import resource  # noqa: F401, PLC0415
    except ImportError:
        return False
    return True
