"""Room to begin with: address space for libraries and threads, where ``ulimit -v`` leaves little of it.

Libraries of linear algebra wait for ever, and use a core, where they find none; what manages a pool of workers dies
of a thread that cannot be started, and whoever waits for a result is not told. So it is asked for beforehand.
"""

import os
from errno import ENOSPC

from ..errors import SdaeverifyError, one_line
from .limits import available_cores

MIB = 2**20
# Measured on two kernels of OpenBLAS: numpy, scipy and pandas take 275 MiB, and 80 MiB more for each further core. A
# thread takes a stack and an arena of the allocator, 72 MiB together.
LIBRARIES, CORE, THREAD = 320 * MIB, 80 * MIB, 72 * MIB
# Threads of the program beside those that manage each of its workers.
OWN, A_WORKER = 2, 2
MOST_CORES = 64


class NoWorkersError(SdaeverifyError):
    """Worker processes cannot be started: there is no memory, no thread or no semaphore to be had."""

    @classmethod
    def of(cls, error: BaseException) -> "NoWorkersError":
        """Return the error that another one of the system is to the user."""
        full = isinstance(error, OSError) and error.errno == ENOSPC
        hint = "is /dev/shm full?" if full else "try fewer --jobs"
        return cls(f"worker processes cannot be started: {one_line(error)}; {hint}")


def address_space(jobs: int) -> int:
    """Return how many bytes of address space the program takes with so many workers, before it has any numbers."""
    cores = min(_cores(), MOST_CORES)
    return LIBRARIES + (cores - 1) * CORE + (THREAD * (OWN + A_WORKER * jobs) if jobs else 0)


def why_no_room(jobs: int) -> str:
    """Return in one line that the limit of the address space is too low for so many workers; empty if it is not.

    Parameters
    ----------
    jobs : int
        Number of worker processes; 0 for the libraries alone.
    """
    limit, needed = _limit(), address_space(jobs)
    if limit is None or limit >= needed:
        return ""
    who = f"{jobs} worker{'s' if jobs > 1 else ''}" if jobs else "the libraries that it loads"
    fewer = ", or try fewer --jobs" if jobs > 1 else ""
    allowed = f"a process may have {limit // MIB} MiB of address space (ulimit -v)"
    return f"{allowed}, and {who} need {needed // MIB} MiB: raise the limit{fewer}"


def _limit() -> int | None:
    try:
        import resource  # noqa: PLC0415 - not on every platform
    except ImportError:
        return None
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if soft == resource.RLIM_INFINITY else soft


def _cores() -> int:
    """Return how many cores the libraries of linear algebra make ready for."""
    asked = os.environ.get("OPENBLAS_NUM_THREADS", "")
    return int(asked) if asked.isdigit() and int(asked) else available_cores()
