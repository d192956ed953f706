"""The limits that somebody asks for, in the words of the command line, and those that hold by default."""

import os
from math import inf
from pathlib import Path

from ..errors import UsageError
from .amounts import read_memory
from .limits import Limits
from .pool import available_cores

TIMEOUT = 600.0
# Of the memory of the machine or of its container, for all workers together.
SHARE = 0.8
CONTAINER = Path("/sys/fs/cgroup/memory.max")


def read_limits(timeout: float | None, memory: str | None, jobs: int | None) -> tuple[int, Limits | None]:
    """Return the number of workers and what they are held to.

    Parameters
    ----------
    timeout : float or None
        Seconds; 0 for no limit, None for the default.
    memory : str or None
        Size; ``0`` for no limit, None for the default.
    jobs : int or None
        Workers that were asked for.

    Returns
    -------
    int
    Limits or None
        None where one job is asked for and all limits are taken away: it runs in this process, which nothing can end
        but itself.

    Raises
    ------
    UsageError
        If one is no limit, or the platform has none.
    """
    if timeout is not None and not 0.0 <= timeout < inf:
        raise UsageError(f"--timeout expects a number of seconds, or 0 for no limit, got {timeout:g}")
    if jobs == 1 and timeout == 0.0 and memory == "0":
        return 1, None
    workers = jobs or available_cores()
    size = _default_memory(workers) if memory is None else 0 if memory == "0" else read_memory("--memory", memory)
    return workers, Limits(TIMEOUT if timeout is None else timeout or inf, size)


def _default_memory(workers: int) -> int:
    if not (hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names):
        return 0
    installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    allowed = CONTAINER.read_text().strip() if CONTAINER.is_file() else ""
    return int(SHARE * min(installed, int(allowed) if allowed.isdigit() else installed) / workers)
