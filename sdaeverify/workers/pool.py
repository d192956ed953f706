"""Worker processes on this machine: a pool of pebble's whose workers load the plugins and are ended on exit."""

import importlib
import multiprocessing
import os
import signal
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager, nullcontext, suppress
from itertools import count
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from typing import Any, TypeVar

from pebble import ProcessPool

from ..contracts.opened import openings
from ..registry.discovery import load_file
from ..registry.foreign_code import MOST_PRINTED, BoundedText
from .limits import Limits, address_space
from .marks import read_mark
from .room import NoWorkersError, why_no_room

Key = TypeVar("Key")
Result = TypeVar("Result")
# Enough calls in flight to keep every worker busy while one result waits for its turn.
BLOCKS_A_WORKER = 3
NONE = Limits()
# Modules that the framework needs at some time: they are loaded before the memory of a worker is limited.
FRAMEWORK = ("sdaeverify.study.blocks", "scipy.linalg", "scipy.optimize", "scipy.sparse.linalg", "scipy.special")
# pebble takes exit code 0 for a worker that has no more calls; our workers never exit for that reason.
ENDED = 256
# Seconds that pebble has to end its workers before they are killed.
ENDING = 10.0


class Processes(Executor):
    """Worker processes, started at the first call; one that dies loses its own call only.

    Processes are spawned rather than forked: they behave alike on every platform and inherit no threads. They are
    ended as soon as the ``with`` block is left, even in the middle of a call.

    Parameters
    ----------
    jobs : int
        Largest number of workers.
    plugins : tuple of str
        Modules and plugin files that each worker loads.
    limits : Limits
        Limits of each worker for the code of plugins.

    Raises
    ------
    NoWorkersError
        If the address space is too small for this number of workers.
    """

    def __init__(self, jobs: int, plugins: tuple[str, ...] = (), limits: Limits = NONE) -> None:
        if why := why_no_room(jobs):
            raise NoWorkersError(why)
        self.jobs, self.limits = jobs, limits
        self._plugins, self._numbers = plugins, count()
        # Directory of the marks that say whose code each worker runs.
        self._marks = tempfile.TemporaryDirectory(prefix="sdaeverify-")
        self._watched: dict[Path, Future[Any]] = {}
        self._pool: ProcessPool | None = None
        self._context = _Context()

    @property
    def active(self) -> bool:
        """Whether calls are made; False if no pool was started, or its managing threads have died."""
        return self._pool is not None and self._pool.active

    def expect(self, calls: int) -> None:
        """Reduce the number of workers to the number of concurrent calls."""
        self.jobs = max(1, min(self.jobs, calls))

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Make a call in the next free worker; start the pool if it has not started or has broken."""
        try:
            if not self.active:
                # Not started yet, or broken because a worker died while none had a call.
                self._end_pool()
                printed = MOST_PRINTED // self.jobs
                self._pool = ProcessPool(
                    self.jobs, initializer=_begin, initargs=(self._plugins, printed), context=self._context
                )
            assert self._pool is not None
            return self._pool.schedule(fn, args, kwargs)
        except (OSError, RuntimeError, MemoryError) as error:
            # The system refuses a semaphore, a thread or a process: an error of the machine, not of a scheme.
            raise NoWorkersError.of(error.__cause__ or error) from error

    def afresh(self) -> "Processes":
        """Return a pool of one new worker, in which no code has used memory or time yet."""
        return Processes(1, self._plugins, self.limits)

    def new_mark(self) -> Path:
        """Return the path of a mark file that no other call uses."""
        return Path(self._marks.name, str(next(self._numbers)))

    def watch(self, mark: Path, future: "Future[Any]") -> None:
        """Register a call whose process is to be ended after the deadline in its mark; see `end_late`."""
        self._watched[mark] = future

    def end_late(self) -> None:
        """End the processes that are past their deadline by cancelling their calls, which pebble does safely."""
        self._watched = {mark: future for mark, future in self._watched.items() if not future.done()}
        for mark, future in self._watched.items():
            if time.monotonic() > read_mark(mark).deadline:
                future.cancel()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:  # noqa: ARG002
        """End the workers, even in the middle of a call; pending calls are dropped."""
        self._end_pool()
        self._marks.cleanup()

    def _end_pool(self) -> None:
        if self._pool is None:
            return
        self._pool.stop()  # type: ignore[no-untyped-call]
        # pebble joins threads of its own, which may wait for a worker to take a call or to release a lock.
        ending = threading.Thread(target=self._pool.join, daemon=True)
        with suppress(RuntimeError):
            # If no thread can be started, pebble has none to wait for either.
            ending.start()
            ending.join(ENDING)
        for worker in self._context.made:
            if SpawnProcess.is_alive(worker):
                worker.terminate()


def executor_for(
    jobs: int, files: Sequence[str] = (), limits: Limits | None = None, modules: Sequence[str] = ()
) -> AbstractContextManager[Executor | None]:
    """Return a pool of worker processes, or a context of None for one job without limits.

    Parameters
    ----------
    jobs : int
        Number of processes; a single job without limits runs in this process.
    files : sequence of str
        Plugin files to load.
    limits : Limits or None
        Limits of each process; if given, even a single job runs in its own process, so that it can be ended.
    modules : sequence of str
        Modules to import, before the files: a file may depend on registrations of a module.
    """
    if limits is None and jobs <= 1:
        return nullcontext(None)
    return Processes(jobs, (*modules, *files), limits or NONE)


def in_turn(
    executor: Executor | None, window: int, calls: Iterable[tuple[Key, Callable[[], Result]]]
) -> Iterator[tuple[Key, Result]]:
    """Make calls and yield their keys and results in the order of the calls.

    Parameters
    ----------
    executor : Executor or None
        None to make the calls in this process.
    window : int
        Number of calls in flight; bounds the memory of results that wait for their turn.
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
    """A process that ends together with all its child processes, and ignores interrupts, which its parent handles."""

    _seen_dead = False

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

    def terminate(self) -> None:
        """Kill the process and all processes that it has started."""
        self._end_group()
        self.kill()

    def is_alive(self) -> bool:
        """Return whether it runs; reports a death at the second query, since pebble first reads which call it had."""
        if super().is_alive():
            return True
        self._end_group()
        self._seen_dead, seen = True, self._seen_dead
        return not seen

    @property
    def exitcode(self) -> int | None:
        """Exit code, with `ENDED` in place of 0, which pebble would ignore."""
        code = super().exitcode
        return ENDED if code == 0 else code

    def _end_group(self) -> None:
        # A worker leads a session of its own. Before it has created one, or on platforms without sessions, only it is
        # killed.
        if self.pid is not None and hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.pid, signal.SIGKILL)


class _Context(SpawnContext):
    """A process context that creates `_Worker` processes and keeps a list of those that run."""

    def __init__(self) -> None:
        super().__init__()
        self.made: list[_Worker] = []

    def Process(self, *args: Any, **named: Any) -> _Worker:  # type: ignore[override]
        self.made = [*filter(SpawnProcess.is_alive, self.made), _Worker(*args, **named)]
        return self.made[-1]


def _begin(plugins: Sequence[str], printed: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setsid"):
        # A session of its own: all processes that plugin code starts can be killed together.
        os.setsid()
    # Send printed output of plugins to stderr, because stdout is reserved for results.
    os.dup2(2, 1)
    if sys.stderr is not None:
        sys.stdout = sys.stderr = BoundedText(sys.stderr, printed)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    openings()
    for plugin in plugins:
        if plugin.endswith(".py"):
            load_file(plugin)
        else:
            importlib.import_module(plugin)
    for module in FRAMEWORK:
        importlib.import_module(module)
    address_space()


def _end_with_parent() -> None:
    # A parent that is killed cannot end its workers.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        if hasattr(os, "killpg"):
            os.killpg(0, signal.SIGKILL)
        os._exit(1)
