"""Check of the address space before workers start, for machines where ``ulimit -v`` leaves too little.

Without enough address space, linear algebra libraries wait for ever and keep a core busy. The manager of a worker
pool dies if a thread cannot be started, and a caller that waits for a result is not informed. So the need is
estimated and checked first.
"""

import os
from errno import ENOSPC

from ..errors import SdaeverifyError, one_line
from .limits import available_cores

MIB = 2**20
# Measured on two kernels of OpenBLAS: numpy, scipy and pandas take 275 MiB, and 80 MiB more for each further core. A
# thread takes a stack and an arena of the allocator, 72 MiB together.
LIBRARIES, CORE, THREAD = 320 * MIB, 80 * MIB, 72 * MIB
# Threads of the program itself, and threads that manage each worker.
OWN, A_WORKER = 2, 2
MOST_CORES = 64


class NoWorkersError(SdaeverifyError):
    """Worker processes cannot be started because memory, threads or semaphores are exhausted."""

    @classmethod
    def of(cls, error: BaseException) -> "NoWorkersError":
        """Return an error of the operating system as one line for the user."""
        full = isinstance(error, OSError) and error.errno == ENOSPC
        hint = "is /dev/shm full?" if full else "try fewer --jobs"
        return cls(f"worker processes cannot be started: {one_line(error)}; {hint}")


def address_space(jobs: int) -> int:
    """Return the address space in bytes that the program takes with `jobs` workers, before any data."""
    cores = min(_cores(), MOST_CORES)
    return LIBRARIES + (cores - 1) * CORE + (THREAD * (OWN + A_WORKER * jobs) if jobs else 0)


def why_no_room(jobs: int) -> str:
    """Return why the limit of the address space is too low for `jobs` workers, or an empty string.

    Parameters
    ----------
    jobs : int
        Number of worker processes; 0 for the libraries only.
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
    """Return the number of cores for which the linear algebra libraries start threads."""
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "")
    return int(threads) if threads.isdigit() and int(threads) else available_cores()
