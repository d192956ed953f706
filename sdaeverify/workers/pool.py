"""Worker processes on this machine: a pool of pebble's, each with its plugins loaded, all ended in the end."""

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
# Enough blocks in flight to keep every worker busy while one result waits for its turn.
BLOCKS_A_WORKER = 3
NONE = Limits()
# What the framework itself needs, sooner or later: it is loaded before the memory of a worker is limited.
FRAMEWORK = ("sdaeverify.study.blocks", "scipy.linalg", "scipy.optimize", "scipy.sparse.linalg", "scipy.special")
# pebble takes the exit code 0 for that of a worker that has nothing left to do, which none of ours comes to.
ENDED = 256
# Seconds that pebble is given to end its workers before they are killed.
ENDING = 10.0


class Processes(Executor):
    """Worker processes, started with the first call; one that dies takes its own call with it and no other.

    They are started anew rather than forked, so that they behave alike on every platform and inherit no threads, and
    ended at once when the block of a ``with`` is left, whatever they do.

    Parameters
    ----------
    jobs : int
        Number of workers at most.
    plugins : tuple of str
        Modules and plugin files that each of them loads.
    limits : Limits
        What the code of plugins is held to in them.

    Raises
    ------
    NoWorkersError
        If there is too little address space for them.
    """

    def __init__(self, jobs: int, plugins: tuple[str, ...] = (), limits: Limits = NONE) -> None:
        if why := why_no_room(jobs):
            raise NoWorkersError(why)
        self.jobs, self.limits = jobs, limits
        self._plugins, self._numbers = plugins, count()
        # In it they mark whose code runs.
        self._marks = tempfile.TemporaryDirectory(prefix="sdaeverify-")
        self._watched: dict[Path, Future[Any]] = {}
        self._pool: ProcessPool | None = None
        self._context = _Context()

    @property
    def active(self) -> bool:
        """Whether calls are made; they are none if the threads that manage them have died."""
        return self._pool is not None and self._pool.active

    def expect(self, calls: int) -> None:
        """Start no more workers than there will be calls side by side."""
        self.jobs = max(1, min(self.jobs, calls))

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Make a call in the next worker that is free."""
        try:
            if not self.active:
                # Broken since a worker died while none had a call, or never made.
                self._end_pool()
                printed = MOST_PRINTED // self.jobs
                self._pool = ProcessPool(
                    self.jobs, initializer=_begin, initargs=(self._plugins, printed), context=self._context
                )
            assert self._pool is not None
            return self._pool.schedule(fn, args, kwargs)
        except (OSError, RuntimeError, MemoryError) as error:
            # No semaphore, no thread or no process is to be had, of which no scheme is the cause.
            raise NoWorkersError.of(error.__cause__ or error) from error

    def afresh(self) -> "Processes":
        """Return a worker in which nobody has used up anything."""
        return Processes(1, self._plugins, self.limits)

    def new_mark(self) -> Path:
        """Return a place for a mark that no other call has."""
        return Path(self._marks.name, str(next(self._numbers)))

    def watch(self, mark: Path, future: "Future[Any]") -> None:
        """End the process of a call when the time of whose code it runs is over."""
        self._watched[mark] = future

    def end_late(self) -> None:
        """End the processes whose time is over: pebble does that, safely, where their calls are cancelled."""
        self._watched = {mark: future for mark, future in self._watched.items() if not future.done()}
        for mark, future in self._watched.items():
            if time.monotonic() > read_mark(mark).deadline:
                future.cancel()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = True) -> None:  # noqa: ARG002
        """End the workers, whatever they do; calls that wait are given up."""
        self._end_pool()
        self._marks.cleanup()

    def _end_pool(self) -> None:
        if self._pool is None:
            return
        self._pool.stop()  # type: ignore[no-untyped-call]
        # pebble waits for threads of its own, which may wait for a worker: to take a call, or to give back a lock.
        ending = threading.Thread(target=self._pool.join, daemon=True)
        with suppress(RuntimeError):
            # Where no thread is to be had, pebble had none to wait for.
            ending.start()
            ending.join(ENDING)
        for worker in self._context.made:
            if SpawnProcess.is_alive(worker):
                worker.terminate()


def executor_for(
    jobs: int, files: Sequence[str] = (), limits: Limits | None = None, modules: Sequence[str] = ()
) -> AbstractContextManager[Executor | None]:
    """Give worker processes, or None for one job without limits: it is done in this process.

    Parameters
    ----------
    jobs : int
        Number of processes; none is started for one without limits.
    files : sequence of str
        Plugin files to load.
    limits : Limits or None
        What each process is held to: it takes one of its own to be ended.
    modules : sequence of str
        Modules to import: one that registers what another defines may set something in it.
    """
    if limits is None and jobs <= 1:
        return nullcontext(None)
    return Processes(jobs, (*modules, *files), limits or NONE)


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
    """A process that ends with all that it has started, and never hears an interrupt, which is for its parent."""

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
        """End the process at once, whatever it does with signals."""
        self._end_group()
        self.kill()

    def is_alive(self) -> bool:
        """Return whether it runs. A death is told at the second look: pebble reads meanwhile which call it took."""
        if super().is_alive():
            return True
        self._end_group()
        self._seen_dead, seen = True, self._seen_dead
        return not seen

    @property
    def exitcode(self) -> int | None:
        """The exit code, for pebble another one than 0."""
        code = super().exitcode
        return ENDED if code == 0 else code

    def _end_group(self) -> None:
        # A worker leads a session of its own; until it does, and where there are none, it is ended alone.
        if self.pid is not None and hasattr(os, "killpg"):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.pid, signal.SIGKILL)


class _Context(SpawnContext):
    """Makes workers, and knows them."""

    def __init__(self) -> None:
        super().__init__()
        self.made: list[_Worker] = []

    def Process(self, *args: Any, **named: Any) -> _Worker:  # type: ignore[override]
        self.made = [*filter(SpawnProcess.is_alive, self.made), _Worker(*args, **named)]
        return self.made[-1]


def _begin(plugins: Sequence[str], printed: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setsid"):
        # All that the code of plugins starts can be ended together.
        os.setsid()
    # What a plugin prints is no result.
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
    # A parent that is killed cannot tell its workers to end.
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        if hasattr(os, "killpg"):
            os.killpg(0, signal.SIGKILL)
        os._exit(1)
