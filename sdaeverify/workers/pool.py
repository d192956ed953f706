"""A pool of worker processes on this machine, and who ends those that take too long.

That is done from outside: nothing that their code does to signals and alarms helps it.
"""

import importlib
import multiprocessing
import os
import signal
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from math import inf
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, TypeVar

from ..registry.discovery import load_file
from ..registry.foreign_code import MOST_PRINTED, BoundedText
from .isolated import Isolated, Turn, end_process
from .limits import Limits, limit_memory, read_mark
from .room import NoWorkersError, why_no_room

# How often the marks of workers are read.
PERIOD = 0.05
# What a process may take beside its time until it begins with a call: to start, to load plugins, to read the call.
BEGINNING = 60.0
Key = TypeVar("Key")
Result = TypeVar("Result")
# Enough blocks in flight to keep every worker busy while one result waits for its turn.
BLOCKS_A_WORKER = 3
NONE = Limits()
# What the framework itself needs, sooner or later: it is loaded before the memory of a worker is limited.
FRAMEWORK = ("sdaeverify.study.blocks", "scipy.linalg", "scipy.optimize", "scipy.sparse.linalg", "scipy.special")


class Timekeeper:
    """A thread that reads the marks of busy workers and ends those whose time is over.

    A worker that is dead while something it has started lives on, and holds its pipes, is buried, too: whoever waits
    for its result would not hear of its death.

    Parameters
    ----------
    pool : Isolated
    """

    def __init__(self, pool: Isolated) -> None:
        self._pool, self._over = pool, threading.Event()
        self._thread = threading.Thread(target=self._watch, name="sdaeverify-timekeeper", daemon=True)

    def __enter__(self) -> "Timekeeper":
        try:
            self._thread.start()
        except RuntimeError as error:
            raise NoWorkersError.of(error) from error
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._over.wait(PERIOD):
            for worker, turn in self._pool.turns().items():
                self.look(worker, turn)

    def look(self, worker: int, turn: Turn) -> None:
        """End a worker that is out of time, and what a dead one has left."""
        if time.monotonic() > deadline(turn, self._pool.limits.timeout):
            self._pool.end(worker, turn)
            return
        self._pool.give_up(worker, turn)
        for process in self._pool.processes(worker):
            if is_dead(process):
                end_process(process)


def deadline(turn: Turn, timeout: float) -> float:
    """Return the time of the monotonic clock until which a worker may be busy as it is.

    Parameters
    ----------
    turn : Turn
    timeout : float
        Seconds, of the limits.
    """
    if turn.mark is None:
        return inf
    try:
        return read_mark(turn.mark).deadline
    except FileNotFoundError:
        return turn.begun + timeout + BEGINNING


def is_dead(process: BaseProcess) -> bool:
    """Tell whether a process has ended, without burying it: that is for whoever waits for it."""
    if process.pid is None or not hasattr(os, "waitid"):
        return False
    try:
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return False


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def worker_pool(
    jobs: int, files: Sequence[str] = (), limits: Limits = NONE, modules: Sequence[str] = ()
) -> Iterator[Executor]:
    """Give an executor of fresh processes, and end them at once when the block is left, whatever they do.

    Workers are started anew rather than forked, so that they behave alike on every platform and inherit no
    threads; plugin files that were named by path are loaded in each of them.

    Parameters
    ----------
    jobs : int
        Number of processes.
    files : sequence of str
        Plugin files to load.
    limits : Limits
        What each process is held to.
    modules : sequence of str
        Modules to import: one that registers what another defines may set something in it.

    Raises
    ------
    NoWorkersError
        If there is too little address space for them.
    """
    if why := why_no_room(jobs):
        raise NoWorkersError(why)

    def make() -> ProcessPoolExecutor:
        return _Pool((*modules, *files), limits.memory, MOST_PRINTED // jobs)

    before = set(multiprocessing.active_children())
    with tempfile.TemporaryDirectory(prefix="sdaeverify-") as marks:
        pool = Isolated(make, jobs, limits, Path(marks))
        try:
            with Timekeeper(pool):
                yield pool
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            _end(set(multiprocessing.active_children()) - before)
            # One may have been about to start.
            pool.shutdown(wait=True)
            _end(set(multiprocessing.active_children()) - before)


@contextmanager
def executor_for(
    jobs: int, files: Sequence[str] = (), limits: Limits | None = None, modules: Sequence[str] = ()
) -> Iterator[Executor | None]:
    """Give a `worker_pool`, or None for one job without limits: it is done in this process.

    Parameters
    ----------
    jobs : int
        Number of processes; none is started for one without limits.
    files : sequence of str
        Plugin files to load.
    limits : Limits or None
        What each process is held to: it takes one of its own to be ended.
    modules : sequence of str
        Modules to import.
    """
    if limits is None and jobs <= 1:
        yield None
        return
    with worker_pool(jobs, files, limits or NONE, modules) as pool:
        yield pool


def _end(workers: Collection[BaseProcess]) -> None:
    for worker in workers:
        end_process(worker)
    for worker in workers:
        worker.join()


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


class _Pool(ProcessPoolExecutor):
    """A pool of one process that is known, so that it can be ended.

    Attributes
    ----------
    processes : list of Process
        What was started: one in the end.
    """

    def __init__(self, plugins: tuple[str, ...], memory: int, printed: int) -> None:
        self.processes: list[BaseProcess] = []
        context = _Context()
        context.Process = self._make_process  # type: ignore[assignment, misc]
        super().__init__(1, mp_context=context, initializer=_begin, initargs=(plugins, memory, printed))

    def _make_process(self, *arguments: Any, **options: Any) -> BaseProcess:
        self.processes.append(_Worker(*arguments, **options))
        return self.processes[-1]


def _begin(plugins: Sequence[str], memory: int, printed: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setsid"):
        # All that the code of plugins starts can be ended together.
        os.setsid()
    # What a plugin prints is no result.
    os.dup2(2, 1)
    if sys.stderr is not None:
        sys.stdout = sys.stderr = BoundedText(sys.stderr, printed)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for plugin in plugins:
        if plugin.endswith(".py"):
            load_file(plugin)
        else:
            importlib.import_module(plugin)
    for module in FRAMEWORK:
        importlib.import_module(module)
    limit_memory(memory)


def _end_with_parent() -> None:
    # A parent that is killed cannot tell its workers to end.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        if hasattr(os, "killpg"):
            os.killpg(0, signal.SIGKILL)
        os._exit(1)
