"""An executor whose worker processes die alone: one that does takes its own call with it and no other."""

import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from functools import partial
from itertools import count
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple

from .limits import Limits
from .room import NoWorkersError

Make = Callable[[], ProcessPoolExecutor]
SECOND = 1.0


class Died(BrokenExecutor):
    """A worker process has died.

    Parameters
    ----------
    why : str
    when : float
        On the monotonic clock.
    late : bool
        Whether it was ended because it had not even begun with its call.
    code : int or None
        Exit code, the negative number of the signal that ended it, or None where that is not known.
    """

    def __init__(self, why: str, when: float, *, late: bool = False, code: int | None = None) -> None:
        super().__init__(why)
        self.when, self.late, self.code = when, late, code


class Turn(NamedTuple):
    """A call that a worker is busy with.

    Attributes
    ----------
    begun : float
        When it was given out, on the monotonic clock.
    mark : Path or None
        Where its process marks whose code runs.
    result : Future, optional
        That of its pool.
    """

    begun: float
    mark: Path | None
    result: Future[Any] | None = None


def end_process(process: BaseProcess) -> None:
    """End a worker process with all that it has started, whether it is alive or not.

    A worker leads a session of its own (see `workers`); until it does, and where there are none, it is ended alone.
    """
    if process.pid is not None and hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()


def _do_nothing(_: Path) -> None:
    """Return."""


def _exit_code(processes: Sequence[BaseProcess]) -> int | None:
    for process in processes:
        # It is dead, or about to be.
        process.join(SECOND)
    return processes[-1].exitcode if processes else None


class Isolated(Executor):
    """A pool of one process for each worker; a pool that breaks is replaced.

    Parameters
    ----------
    make : callable
        Returns a pool of one process.
    jobs : int
        Number of workers.
    limits : Limits
        What its processes are held to.
    marks : Path
        Folder in which they mark whose code runs.
    """

    def __init__(self, make: Make, jobs: int, limits: Limits, marks: Path) -> None:
        self.limits = limits
        self._marks, self._numbers = marks, count()
        self._make, self._lock = make, threading.RLock()
        self._idle, self._pools = list(range(jobs)), dict[int, ProcessPoolExecutor]()
        self._retired: list[ProcessPoolExecutor] = []
        self._waiting: deque[tuple[Future[Any], partial[Any], bool]] = deque()
        self._turns, self._late = dict[int, Turn](), set[int]()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Make a call in the next worker that is free; its future fails with `Died` if the worker does."""
        return self._begin(partial(fn, *args, **kwargs), fresh=False)

    def submit_afresh(self, fn: Callable[..., Any], /, *args: Any) -> Future[Any]:
        """Make a call in a new process, in which nobody has used up anything."""
        return self._begin(partial(fn, *args), fresh=True)

    def start(self, count: int) -> None:
        """Start some workers before there is a call for them: they load their code meanwhile."""
        for _ in range(min(count, len(self._idle))):
            self._begin(partial(_do_nothing, self.new_mark()), fresh=False)

    def new_mark(self) -> Path:
        """Return a place for a mark that no other call has."""
        return self._marks / str(next(self._numbers))

    def turns(self) -> dict[int, Turn]:
        """Return what each worker is busy with, by its number."""
        with self._lock:
            return dict(self._turns)

    def processes(self, worker: int) -> Sequence[BaseProcess]:
        """Return the processes of a worker: one, or none if it has not been started or is no pool of `workers`."""
        with self._lock:
            return tuple(getattr(self._pools.get(worker), "processes", ()))

    def end(self, worker: int, turn: Turn) -> None:
        """End the process of a worker that takes too long, with all it has started, if it still has the same turn."""
        with self._lock:
            if self._turns.get(worker) is turn:
                self._late.add(worker)
                for process in self.processes(worker):
                    end_process(process)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers; calls that wait are made first, or given up."""
        with self._lock:
            if cancel_futures:
                for future, *_ in self._waiting:
                    future.cancel()
                self._waiting.clear()
            pools = [*self._pools.values(), *self._retired]
        for pool in pools:
            pool.shutdown(wait=wait, cancel_futures=cancel_futures)

    def _begin(self, call: "partial[Any]", *, fresh: bool) -> Future[Any]:
        future: Future[Any] = Future()
        with self._lock:
            self._waiting.append((future, call, fresh))
            self._dispatch()
        return future

    def _dispatch(self) -> None:
        while self._idle and self._waiting:
            worker, (future, call, fresh) = self._idle.pop(), self._waiting.popleft()
            if fresh and worker in self._pools:
                self._retire(worker)
            try:
                inner = self._submit(worker, call)
                mark = next((argument for argument in call.args if isinstance(argument, Path)), None)
                self._turns[worker] = Turn(time.monotonic(), mark, inner)
            except Exception as error:
                # Whoever waits for the call must hear of it, in whatever thread this is.
                self._idle.append(worker)
                future.set_exception(error)
            else:
                inner.add_done_callback(partial(self._finish, worker, future))

    def _submit(self, worker: int, call: "partial[Any]") -> Future[Any]:
        if worker in self._pools:
            try:
                return self._pools[worker].submit(call)
            except BrokenExecutor:
                # It died while it had nothing to do.
                self._retire(worker)
        try:
            pool = self._make()
            future = pool.submit(call)
        except (OSError, RuntimeError, MemoryError) as error:
            # No semaphore, no thread or no process is to be had, of which no scheme is the cause.
            raise NoWorkersError.of(error) from error
        self._pools[worker] = pool
        return future

    def give_up(self, worker: int, turn: Turn) -> None:
        """Fail a call whose pool has nobody left that would: the thread that manages it has died."""
        with self._lock:
            manager = getattr(self._pools.get(worker), "_executor_manager_thread", None)
            lost = manager is not None and not manager.is_alive() and self._turns.get(worker) is turn
        if lost and turn.result is not None and not turn.result.done():
            turn.result.set_exception(BrokenExecutor("the thread that manages its worker has died"))

    def _retire(self, worker: int) -> None:
        self._retired.append(self._pools.pop(worker))
        self._retired[-1].shutdown(wait=False)

    def _finish(self, worker: int, future: Future[Any], inner: Future[Any]) -> None:
        error = None if inner.cancelled() else inner.exception()
        with self._lock:
            turn, late = self._turns.pop(worker, None), worker in self._late
            if isinstance(error, BrokenExecutor):
                begun = turn is None or turn.mark is None or turn.mark.is_file()
                error = Died(
                    str(error), time.monotonic(), late=late and not begun, code=_exit_code(self.processes(worker))
                )
            if isinstance(error, Died) or late:
                self._late.discard(worker)
                for process in self.processes(worker):
                    end_process(process)
                self._retire(worker)
            self._idle.append(worker)
            self._dispatch()
        if inner.cancelled():
            future.cancel()
        elif error is not None:
            future.set_exception(error)
        else:
            future.set_result(inner.result())
