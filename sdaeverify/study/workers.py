"""A pool of worker processes on this machine."""

import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager

from ..discovery import load_file

# Enough blocks in flight to keep every worker busy while one result waits for its turn.
BLOCKS_A_WORKER = 3


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def worker_pool(jobs: int, files: Sequence[str] = ()) -> Iterator[Executor]:
    """Give an executor of fresh processes, and end them at once if the block is left by an exception.

    Workers are started anew rather than forked, so that they behave alike on every platform and inherit no
    threads; plugin files that were named by path are loaded in each of them.

    Parameters
    ----------
    jobs : int
        Number of processes.
    files : sequence of str
        Plugin files to load.
    """
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin, initargs=(tuple(files),))
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    pool.shutdown()


def _begin(files: Sequence[str]) -> None:
    # An interrupt is for the process that collects the results; workers end when it tells them to.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for file in files:
        load_file(file)
