"""Options that hold the code of plugins to limits."""

import os
from math import inf
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..gate.amounts import read_memory
from ..workers.limits import Limits
from ..workers.pool import available_cores
from .options import combine_options, once

TIMEOUT = 600.0
# Of the memory of the machine or of its container, for all workers together.
SHARE = 0.8
CONTAINER = Path("/sys/fs/cgroup/memory.max")


# How the code of plugins is held to limits.
limits = combine_options(
    once(
        "--timeout",
        type=float,
        metavar="SECONDS",
        help=f"What a scheme may take on a block of paths; 0 for no limit.  [default: {TIMEOUT:.0f}]",
    ),
    once(
        "--memory",
        metavar="SIZE",
        help=f"Memory of each worker, such as 2G; 0 for no limit.  [default: {SHARE:.0%} of all, shared]",
    ),
)


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


def options_of(options: dict[str, Any]) -> tuple[int, Limits | None]:
    """Return `read_limits` of a command's options."""
    return read_limits(options["timeout"], options["memory"], options["jobs"])


def _default_memory(workers: int) -> int:
    if not (hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names):
        return 0
    installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    allowed = CONTAINER.read_text().strip() if CONTAINER.is_file() else ""
    return int(SHARE * min(installed, int(allowed) if allowed.isdigit() else installed) / workers)
