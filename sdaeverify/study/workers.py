"""A pool of worker processes on this machine."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import TypeVar

from ..discovery import load_file

Key = TypeVar("Key")
Result = TypeVar("Result")

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
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, mp_context=_Context(), initializer=_begin, initargs=(tuple(files),))
    try:
        yield pool
    except BaseException:
        for worker in set(multiprocessing.active_children()) - before:
            worker.terminate()
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    pool.shutdown()


def in_turn(
    executor: Executor | None, window: int, calls: Iterable[tuple[Key, Callable[[], Result]]]
) -> Iterator[tuple[Key, Result]]:
    """Make calls and yield their results in the order of the calls, whatever the workers do.

    Parameters
    ----------
    executor : Executor or None
        Calls are made in this process if there is none.
    window : int
        Calls in flight: bounds the memory of results that wait for their turn.
    calls : iterable of (key, callable)
    """
    if executor is None:
        yield from ((key, call()) for key, call in calls)
        return
    waiting: deque[tuple[Key, Future[Result]]] = deque()
    for key, call in calls:
        waiting.append((key, executor.submit(call)))
        if len(waiting) >= window:
            first, future = waiting.popleft()
            yield first, future.result()
    yield from ((key, future.result()) for key, future in waiting)


class _Worker(SpawnProcess):
    """A process that never hears an interrupt: it is for the process that collects the results."""

    def start(self) -> None:
        if not hasattr(signal, "pthread_sigmask"):
            super().start()
            return
        # The mask is inherited, so that not even the start of the interpreter can be interrupted.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


class _Context(SpawnContext):
    Process = _Worker


def _begin(files: Sequence[str]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for file in files:
        load_file(file)


def _end_with_parent() -> None:
    # A parent that is killed cannot tell its workers to end.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
