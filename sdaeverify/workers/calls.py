"""Calls in isolated workers: what one returns or, if its process dies of it, whose code that was, and why."""

import pickle
import signal
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from ..errors import FAULTS, UsageError, one_line
from ..registry.discovery import FILE_PREFIX
from .isolated import Died, Isolated
from .limits import Mark, read_mark

Value = TypeVar("Value")
ELSE = "define it at the top level of a module, or use one job"
DIED = "its worker process died"


class Lost(NamedTuple):
    """What there is of a call whose process died of it.

    Attributes
    ----------
    mark : Mark
        Whose code ran.
    late : bool
        Whether the process was ended because it took too long.
    timeout : float
        Seconds that it had.
    code : int or None
        As in `Died`.
    """

    mark: Mark
    late: bool
    timeout: float
    code: int | None = None

    def why(self, late: str) -> str:
        """Return the reason in words; those for a process that was late have a place for the limit."""
        return late.format(self.timeout) if self.late else f"{DIED}{_describe_end(self.code)}"


class Call(Generic[Value]):
    """A call in an isolated worker.

    Parameters
    ----------
    executor : Isolated
    function : callable, (argument, mark, timeout) -> value
        Marks in the file `mark` whose code it runs, as `Watchdog` does.
    argument : bytes
    fresh : bool, optional
        Whether it is made in a new process.

    Attributes
    ----------
    fresh : bool
        Whether it was in the end, since the first process had died before it began.
    """

    def __init__(
        self,
        executor: Isolated,
        function: Callable[[bytes, Path, float], Value],
        argument: bytes,
        *,
        fresh: bool = False,
    ) -> None:
        self.fresh = fresh
        self._executor, self._function, self._argument = executor, function, argument
        self._mark = executor.new_mark()
        self._future = self._send()

    @property
    def future(self) -> "Future[Value]":
        """What is waited for."""
        return self._future

    def outcome(self) -> Value | Lost:
        """Wait for the value and return it, or what is left if the process died of the call."""
        try:
            return self._future.result()
        except Died as death:
            if self._mark.is_file() or self.fresh:
                return self._explain_death(death)
        finally:
            self._mark.unlink(missing_ok=True)
        # It died before it began with this, of something else.
        self.fresh = True
        self._future = self._send()
        return self.outcome()

    def _send(self) -> "Future[Value]":
        submit = self._executor.submit_afresh if self.fresh else self._executor.submit
        return submit(self._function, self._argument, self._mark, self._executor.limits.timeout)

    def _explain_death(self, death: Died) -> Lost:
        mark = read_mark(self._mark) if self._mark.is_file() else Mark()
        late = death.late or mark.timed_out(death.when)
        return Lost(mark, late, self._executor.limits.timeout, death.code)


def _describe_end(code: int | None) -> str:
    if code is None:
        return ", perhaps for want of memory"
    if code >= 0:
        return f" with exit code {code}"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return f" of {name}{', perhaps for want of memory' if name == 'SIGKILL' else ''}"


def pickle_argument(argument: object, what: str) -> bytes:
    """Return an argument as bytes.

    Raises
    ------
    UsageError
        If it cannot be sent: `what` says who is to blame.
    """
    try:
        return pickle.dumps(argument)
    except FAULTS as error:
        raise UsageError(f"{what} cannot be sent to worker processes: {one_line(error)}; {ELSE}") from error


def unpickle_argument(argument: bytes, *passed: type[BaseException]) -> Any:
    """Return an argument in a worker process.

    Raises
    ------
    UsageError
        If it cannot be read there: a class or function of it is not at the top level of its module. Errors of the
        types `passed` are raised as they are.
    """
    try:
        return pickle.loads(argument)
    except passed:
        raise
    except FAULTS as error:
        if isinstance(error, ModuleNotFoundError) and str(error.name).startswith(FILE_PREFIX):
            raise UsageError("a plugin file was saved while the run was under way; run it again") from None
        what = "a scheme, problem or measure cannot be read in a worker process"
        raise UsageError(f"{what}: {one_line(error)}; {ELSE}") from None
