"""Calls in workers: their value or, if the process dies, the code that ran and the reason."""

import os
import pickle
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from pebble import ProcessExpired

from ..errors import FAULTS, UsageError, one_line
from ..registry.discovery import FILE_PREFIX
from ..registry.load import Registry
from ..simulate.ensemble import Marker
from .executors import LostExecutorError, Plugins, Workers, crew_of
from .limits import Limits, available_cores, is_exhausted, limited_memory
from .marks import NOBODY, Mark, Watchdog, read_mark
from .pool import BLOCKS_A_WORKER, ENDED, Processes, in_turn

Argument = TypeVar("Argument")
Value = TypeVar("Value")
# A function at the top level of a module of the framework, called with its argument and a marker of the running code.
Function = Callable[[Any, Marker], Value]
ELSE = "define it at the top level of a module, or use one job"
DIED = "its worker process died"
GONE = "the executor accepts no more work"
# Exit code of a worker that leaves its call to another one, for lack of memory: EX_TEMPFAIL of sysexits.
EXHAUSTED = 75
# Seconds between two readings of the marks of workers.
PERIOD = 0.1


class Lost(NamedTuple):
    """Result of a call whose worker process died.

    Attributes
    ----------
    mark : Mark
        The scheme and measure whose code ran.
    why : str
    late : bool
        Whether the process was ended because it exceeded its time.
    """

    mark: Mark
    why: str
    late: bool = False


class Call(Generic[Value]):
    """A call in a worker process of this machine.

    pebble ends a process safely, and no other one, when its call is cancelled. Its own deadline is for a whole call.
    Many schemes share the paths of a block, and each has a deadline of its own, which the process writes to its mark.

    Parameters
    ----------
    processes : Processes
    function : callable, (argument, Marker) -> Value
    argument : bytes
    """

    def __init__(self, processes: Processes, function: Function[Value], argument: bytes) -> None:
        self._processes, self._mark = processes, processes.new_mark()
        self._arguments = function, argument, self._mark, processes.limits
        self.future = self._send()

    @property
    def done(self) -> bool:
        """Whether the call has ended; also ends all watched processes that have exceeded their time."""
        self._processes.end_late()
        if not (self.future.done() or self._processes.active):
            raise BrokenExecutor("the threads that manage worker processes have died")
        return self.future.done()

    def outcome(self) -> Value | Lost:
        """Wait for the value and return it, or a `Lost` if the process died."""
        try:
            return self._outcome()
        except BrokenProcessPool:
            # If a worker died between two calls while no other was busy, pebble gives up the whole pool: repeat the
            # call.
            self.future = self._send()
            return self._outcome()
        finally:
            self._mark.unlink(missing_ok=True)

    def _send(self) -> "Future[bytes]":
        future = self._processes.submit(call_marked, *self._arguments)
        self._processes.watch(self._mark, future)
        return future

    def _outcome(self) -> Value | Lost:
        while not self.done:
            wait([self.future], PERIOD)
        try:
            value: Value = pickle.loads(self.future.result())
            return value
        except CancelledError:
            return Lost(read_mark(self._mark), "", late=True)
        except ProcessExpired as death:
            if death.exitcode == EXHAUSTED and read_mark(self._mark).scheme == NOBODY:
                # No code of a plugin has run in this call, and a new worker has all of its memory.
                self.future = self._send()
                return self._outcome()
            return Lost(read_mark(self._mark), f"{DIED}{_describe_end(death.exitcode)}")


class RemoteCall(Generic[Value]):
    """A call in a worker of any executor; argument and value are sent as bytes.

    A call whose worker dies or leaves the cluster is repeated once; a second failure is an error of the executor.

    Parameters
    ----------
    workers : Workers
    function : callable, (argument, Marker) -> Value
    argument : bytes
    """

    def __init__(self, workers: Workers, function: Function[Value], argument: bytes) -> None:
        self._workers, self._function, self._argument = workers, function, argument
        self.future = self._send()

    def outcome(self) -> Value | Lost:
        """Wait for the value and return it.

        Raises
        ------
        LostExecutorError
            If the executor fails twice, takes no more calls, or is gone.
        """
        for last in (False, True):
            try:
                value: Value = pickle.loads(self.future.result())
                return value
            except UsageError:
                raise
            except Exception as error:
                # The function returns its own errors as values, so this error comes from the executor.
                if why := self._workers.why_lost():
                    raise LostExecutorError(why) from error
                if last:
                    raise LostExecutorError(f"a worker of the executor was lost twice: {one_line(error)}") from error
                self.future = self._send()
        raise AssertionError

    def _send(self) -> "Future[bytes]":
        assert self._workers.executor is not None
        try:
            return self._workers.executor.submit(call_anywhere, self._function, self._argument, self._workers.plugins)
        except Exception as error:
            raise LostExecutorError(self._workers.why_lost() or f"{GONE}: {one_line(error)}") from error


def call_marked(function: Function[Any], argument: bytes, mark: Path, limits: Limits) -> bytes:
    """Make a call in a worker process under its limits, and return the pickled value.

    Parameters
    ----------
    function : callable, (argument, Marker) -> object
    argument : bytes
    mark : Path
        File from which the parent process reads whose code runs and the deadline of that code.
    limits : Limits
    """
    if is_exhausted(limits.memory):
        os._exit(EXHAUSTED)
    watchdog = Watchdog(mark, limits.timeout)
    with limited_memory(limits.memory):
        value = function(unpickle_argument(argument, MemoryError), watchdog)
    return pickle.dumps(value)


def call_anywhere(function: Function[Any], argument: bytes, plugins: Plugins) -> bytes:
    """Make a call in a worker that has not loaded the plugin files, and return the pickled value.

    Parameters
    ----------
    function : callable, (argument, Marker) -> object
    argument : bytes
    plugins : Plugins
        Plugins to load before the call.
    """
    plugins.load()
    return pickle.dumps(function(unpickle_argument(argument), Marker()))


def call_in_turn(
    function: Callable[[Argument], Value],
    named: Iterable[tuple[str, Argument]],
    registry: Registry,
    jobs: int | None = None,
    executor: Executor | str | None = None,
    ahead: int = BLOCKS_A_WORKER,
) -> Iterator[tuple[Argument, Value]]:
    """Call a function on workers with the plugins of a registry; yield each argument with its value, in order.

    Parameters
    ----------
    function : callable, argument -> value
        At the top level of a module, called in this process if there is one job and no executor.
    named : iterable of (str, argument)
        Arguments, each with its name for the message if it cannot be pickled. They are read as workers get free, so
        that a generator can end after any value.
    registry : Registry
    jobs : int, optional
        Number of workers; all available cores if omitted.
    executor : Executor or str, optional
        As in `sdaeverify.verify`.
    ahead : int
        Number of calls a worker that are submitted before their values are needed.

    Raises
    ------
    UsageError
        If an argument cannot be pickled.
    """
    with crew_of(jobs or available_cores(), None, registry, executor) as crew:

        def calls() -> Iterator[tuple[Argument, Callable[[], Any]]]:
            for name, argument in named:
                if crew.executor is None:
                    yield argument, partial(function, argument)
                else:
                    sent = pickle_argument((function, argument), name)
                    yield argument, partial(call_anywhere, _apply, sent, crew.plugins)

        for argument, answer in in_turn(crew.executor, ahead * crew.jobs, calls()):
            yield argument, answer if crew.executor is None else pickle.loads(answer)


def _apply(call: tuple[Callable[[Argument], Value], Argument], _: Marker) -> Value:
    function, argument = call
    return function(argument)


def _describe_end(code: int) -> str:
    if code >= 0:
        return f" with exit code {code % ENDED}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return f" of {name}{', possibly out of memory' if name == 'SIGKILL' else ''}"


def pickle_argument(argument: object, what: str) -> bytes:
    """Return a pickled argument.

    Raises
    ------
    UsageError
        If it cannot be pickled; `what` names the argument in the message.
    """
    try:
        return pickle.dumps(argument)
    except FAULTS as error:
        raise UsageError(f"{what} cannot be sent to worker processes: {one_line(error)}; {ELSE}") from error


def unpickle_argument(argument: bytes, *passed: type[BaseException]) -> Any:
    """Return an argument unpickled in a worker process.

    Raises
    ------
    UsageError
        If it cannot be unpickled, as for a class or function that is not at the top level of its module. Errors of
        the types `passed` are raised unchanged.
    """
    try:
        return pickle.loads(argument)
    except passed:
        raise
    except FAULTS as error:
        if isinstance(error, ModuleNotFoundError) and str(error.name).startswith(FILE_PREFIX):
            raise UsageError("a plugin file changed during the run; run it again") from None
        what = "a scheme, problem or measure cannot be read in a worker process"
        raise UsageError(f"{what}: {one_line(error)}; {ELSE}") from None
