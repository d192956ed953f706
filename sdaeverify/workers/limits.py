"""Limits of a worker process: time and memory for one scheme on one block of paths, given or by default."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from math import inf
from pathlib import Path

from ..errors import UsageError

try:
    import resource
except ImportError:  # not on every platform
    resource = None  # type: ignore[assignment]

TIMEOUT = 600.0
# Share of the memory of the machine, or of its container, for all workers together.
SHARE = 0.8
CONTAINER = Path("/sys/fs/cgroup/memory.max")
UNITS = {"": 1, "K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40}
# Least memory: libraries that a worker loads at its start, and gbm and the pendulum on all measures, take 50M to
# 100M.
LEAST = 2**28
# Share of its memory that a worker needs free to begin a call. Libraries and ordinary schemes leave more than half.
# Size: of the memory of a worker.
FREE = 0.5
_AMOUNT = re.compile(r"([0-9]{1,15}(?:\.[0-9]{1,6})?) ?([KMGT]?)i?B?")


@dataclass(frozen=True)
class Limits:
    """Limits of a worker process.

    Attributes
    ----------
    timeout : float
        Seconds that the code of one scheme may run on one block; infinite for no limit.
    memory : int
        Bytes of address space beyond those in use at the worker's start; 0 for no limit.

    Raises
    ------
    UsageError
        If the timeout is not positive, or the platform cannot limit memory.
    """

    timeout: float = inf
    memory: int = 0

    def __post_init__(self) -> None:
        if not self.timeout > 0.0:
            raise UsageError(f"timeout must be a positive number of seconds, got {self.timeout:g}")
        if self.memory and resource is None:
            raise UsageError("this platform cannot limit the memory of a process; leave out --memory")


def read_limits(timeout: float | None, memory: str | None, jobs: int | None) -> tuple[int, Limits | None]:
    """Return the number of workers and their limits.

    Parameters
    ----------
    timeout : float or None
        Seconds; 0 for no limit, None for the default.
    memory : str or None
        Size; ``0`` for no limit, None for the default.
    jobs : int or None
        Number of workers that was given; None for one per available core.

    Returns
    -------
    int
    Limits or None
        With one job and all limits removed: calls are then made in this process, where code that hangs cannot be
        ended.

    Raises
    ------
    UsageError
        If a value is not a valid limit, or the platform cannot limit memory.
    """
    if timeout is not None and not 0.0 <= timeout < inf:
        raise UsageError(f"--timeout expects a number of seconds, or 0 for no limit, got {timeout:g}")
    if jobs == 1 and timeout == 0.0 and memory == "0":
        return 1, None
    workers = jobs or available_cores()
    size = _default_memory(workers) if memory is None else 0 if memory == "0" else read_memory("--memory", memory)
    return workers, Limits(TIMEOUT if timeout is None else timeout or inf, size)


def read_memory(name: str, text: str) -> int:
    """Return a memory size in bytes.

    Parameters
    ----------
    name : str
        Name of the option or key, for the message.
    text : str
        A number, optionally followed by K, M, G or T for powers of 1024, such as ``2G``.

    Raises
    ------
    UsageError
        If it is not such a size, or less than `LEAST`, which every worker needs.
    """
    match = _AMOUNT.fullmatch(text.strip())
    size = int(float(match[1]) * UNITS[match[2]]) if match else 0
    if size < 1:
        raise UsageError(f"{name} expects an amount of memory such as 500M or 2G, got {text!r}")
    if size < LEAST:
        raise UsageError(f"{name} expects at least {LEAST >> 20}M, which a worker itself needs, got {text!r}")
    return size


def _default_memory(workers: int) -> int:
    if not (hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names):
        return 0
    installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    allowed = CONTAINER.read_text().strip() if CONTAINER.is_file() else ""
    return int(SHARE * min(installed, int(allowed) if allowed.isdigit() else installed) / workers)


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def limited_memory(extra: int) -> Iterator[None]:
    """Limit the address space to `extra` bytes beyond its size at the first call of `address_space`.

    The limit is removed for the code that sends results and receives calls: a call that could not be read for lack of
    memory would be lost.
    """
    if not extra or resource is None:
        yield
        return
    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = address_space() + extra
    resource.setrlimit(resource.RLIMIT_AS, (wanted if hard < 0 else min(wanted, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))


def is_exhausted(extra: int) -> bool:
    """Return whether earlier calls have left less than `FREE` of the memory of this worker, as a cache of them may.

    Parameters
    ----------
    extra : int
        As for `limited_memory`.
    """
    return bool(extra) and _size() - address_space() > (1.0 - FREE) * extra


@cache
def address_space() -> int:
    """Return the bytes of address space that this process had at the first call, which is cached."""
    return _size()


def _size() -> int:
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE") if statm.is_file() else 0
