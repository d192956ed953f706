"""Executors by name, and calls in those whose workers are nobody's here: on other machines, in threads, anywhere."""

import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from importlib import import_module, metadata
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from ..contracts.labels import did_you_mean
from ..errors import FAULTS, SdaeverifyError, UsageError, one_line
from ..registry.discovery import load_source
from ..registry.load import Registry

Value = TypeVar("Value")
# Entry points: functions of an address, empty if none is given, and a number of workers, which give a `Crew`.
GROUP = "sdaeverify.executors"
PROCESSES = "processes"
GONE = "the executor takes no more work"
# A scheduler that has not answered by then is not there.
ANSWERS_WITHIN = "10s"


class Plugins(NamedTuple):
    """What a process loads, so that it runs what was registered in another.

    Attributes
    ----------
    modules : tuple of str
        Of installed distributions.
    files : tuple of (str, bytes)
        Plugin files with their content.
    """

    modules: tuple[str, ...] = ()
    files: tuple[tuple[str, bytes], ...] = ()

    @classmethod
    def of(cls, registry: Registry) -> "Plugins":
        """Return the plugins of a registry, with what their files hold now."""
        return cls(registry.modules, tuple((file, Path(file).read_bytes()) for file in registry.files))

    def load(self) -> None:
        """Import all of them."""
        for module in self.modules:
            import_module(module)
        for file, source in self.files:
            load_source(Path(file), source)


class Crew(NamedTuple):
    """Who makes calls.

    Attributes
    ----------
    executor : Executor or None
        None for this process.
    jobs : int
        Number of workers.
    plugins : Plugins
        What workers elsewhere load before anything else.
    why_lost : callable, () -> str
        Why no call can come back any more, because who gives them out is gone; empty if it can.
    """

    executor: Executor | None
    jobs: int
    plugins: Plugins = Plugins()
    why_lost: Callable[[], str] = str


class LostExecutorError(SdaeverifyError, BrokenExecutor):
    """An executor makes no more calls: its workers are lost, or its scheduler is."""


class Serial(Executor):
    """An executor that makes each call at once, in this process."""

    def submit(self, fn: Callable[..., Value], /, *args: Any, **kwargs: Any) -> "Future[Value]":
        """Make a call; its future is done."""
        future: Future[Value] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except FAULTS as error:
            future.set_exception(error)
        return future


class Remote(Generic[Value]):
    """A call in a worker of any executor: bytes go there, and bytes come home.

    A worker that dies, or whose machine leaves, costs one more call; what fails twice is the caller's error.

    Parameters
    ----------
    crew : Crew
    function : callable, bytes -> Value
        At the top level of a module of the framework.
    argument : bytes
    """

    def __init__(self, crew: Crew, function: Callable[[bytes], Value], argument: bytes) -> None:
        self._crew, self._function, self._argument = crew, function, argument
        self._future = self._send()

    @property
    def future(self) -> "Future[bytes]":
        """What is waited for."""
        return self._future

    def outcome(self) -> Value:
        """Wait for the value and return it.

        Raises
        ------
        LostExecutorError
            If the executor fails twice, takes no more calls, or is gone.
        """
        for last in (False, True):
            try:
                value: Value = pickle.loads(self._future.result())
                return value
            except UsageError:
                raise
            except Exception as error:
                # Whatever the function could raise it returns: this is of the executor.
                if why := self._crew.why_lost():
                    raise LostExecutorError(why) from error
                if last:
                    raise LostExecutorError(f"a worker of the executor was lost twice: {one_line(error)}") from error
                self._future = self._send()
        raise AssertionError

    def _send(self) -> "Future[bytes]":
        assert self._crew.executor is not None
        try:
            return self._crew.executor.submit(call_pickled, self._function, self._argument, self._crew.plugins)
        except Exception as error:
            raise LostExecutorError(self._crew.why_lost() or f"{GONE}: {one_line(error)}") from error


def call_pickled(function: Callable[[bytes], object], argument: bytes, plugins: Plugins) -> bytes:
    """Make a call in a worker that has never seen the plugin files, and return its value as bytes.

    Parameters
    ----------
    function : callable, bytes -> object
    argument : bytes
        What it is called with.
    plugins : Plugins
        Files that have to be loaded first.
    """
    plugins.load()
    return pickle.dumps(function(argument))


@contextmanager
def open_crew(text: str, jobs: int, registry: Registry) -> Iterator[Crew]:
    """Give the workers that a name stands for.

    Parameters
    ----------
    text : str
        ``NAME``, ``NAME:ADDRESS`` or ``NAME://ADDRESS``.
    jobs : int
        Number of workers, where that is not for the address to say.
    registry : Registry
        With the plugins that they load.

    Raises
    ------
    UsageError
        If there is no such executor, or it cannot be reached.
    """
    name, _, address = text.partition(":")
    known = {entry.name: entry for entry in metadata.entry_points(group=GROUP)}
    if name not in known:
        names = [PROCESSES, *sorted(known)]
        raise UsageError(f"unknown executor {name!r}{did_you_mean(name, names)} (known: {', '.join(names)})")
    try:
        crew = known[name].load()(address.removeprefix("//"), jobs)
        opened = crew.__enter__()
    except ImportError as error:
        raise UsageError(f"executor {name} needs a library that is not installed: {one_line(error)}") from error
    except FAULTS as error:
        raise UsageError(f"executor {text} cannot be used: {one_line(error)}") from error
    with _close_at_end(crew):
        yield opened._replace(plugins=Plugins.of(registry))


@contextmanager
def _close_at_end(crew: AbstractContextManager[Crew]) -> Iterator[None]:
    try:
        yield
    finally:
        crew.__exit__(None, None, None)


def serial(_: str, __: int) -> AbstractContextManager[Crew]:
    """Give an executor in this process, for searches of errors: no limit holds there."""
    return nullcontext(Crew(Serial(), 1))


@contextmanager
def dask(address: str, jobs: int) -> Iterator[Crew]:
    """Give the workers of a Dask cluster at an address, or of one on this machine."""
    from distributed import Client, LocalCluster  # noqa: PLC0415

    if address:
        with Client(f"tcp://{address}", timeout=ANSWERS_WITHIN) as client:
            lost = partial(_why_lost, client, f"the scheduler at {address} is dead, or cannot be reached any more")
            yield Crew(client.get_executor(), max(1, sum(client.nthreads().values())), why_lost=lost)
        return
    with (
        LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        yield Crew(client.get_executor(), jobs)


def _why_lost(client: Any, words: str) -> str:
    return "" if client.status == "running" else words


@contextmanager
def loky(_: str, jobs: int) -> Iterator[Crew]:
    """Give processes of loky; one that dies takes the others with it, which are made anew."""
    from loky import get_reusable_executor  # noqa: PLC0415

    class Renewed(Executor):
        """An executor that is made anew where it has broken."""

        def submit(self, fn: Callable[..., Value], /, *args: Any, **kwargs: Any) -> "Future[Value]":
            """Make a call in one of the processes."""
            future: Future[Value] = get_reusable_executor(max_workers=jobs, timeout=None).submit(fn, *args, **kwargs)
            return future

    try:
        yield Crew(Renewed(), jobs)
    finally:
        get_reusable_executor(max_workers=jobs, timeout=None).shutdown(wait=True, kill_workers=True)


@contextmanager
def mpi(_: str, jobs: int) -> Iterator[Crew]:
    """Give the processes that mpiexec has started for mpi4py.futures."""
    from mpi4py.futures import MPIPoolExecutor  # noqa: PLC0415

    with MPIPoolExecutor(max_workers=jobs) as executor:
        yield Crew(executor, jobs)
