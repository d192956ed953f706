"""Executors by name; their workers may be threads, processes, or run on other machines."""

from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ..contracts.opened import openings
from ..contracts.spelling import did_you_mean
from ..errors import FAULTS, SdaeverifyError, UsageError, one_line
from ..registry.discovery import enabled_entry_points, load_source
from ..registry.load import Registry
from .limits import Limits
from .pool import executor_for

Value = TypeVar("Value")
# Entry points: functions of an address (empty if none is given) and a number of workers that return a `Workers`.
GROUP = "sdaeverify.executors"
PROCESSES = "processes"
# A scheduler that has not answered within this time is considered unreachable.
ANSWERS_WITHIN = "10s"


class Plugins(NamedTuple):
    """Plugins that a worker loads to have the same registrations as the parent process.

    Attributes
    ----------
    modules : tuple of str
        Importable modules of installed distributions.
    files : tuple of (str, bytes)
        Plugin files with their contents.
    """

    modules: tuple[str, ...] = ()
    files: tuple[tuple[str, bytes], ...] = ()

    @classmethod
    def of(cls, registry: Registry) -> "Plugins":
        """Return the plugins of a registry, with the current contents of its files."""
        return cls(registry.modules, tuple((file, Path(file).read_bytes()) for file in registry.paths))

    def load(self) -> None:
        """Import all of them, and start recording the files that their code opens."""
        openings()
        for module in self.modules:
            import_module(module)
        for file, source in self.files:
            load_source(Path(file), source)


class Workers(NamedTuple):
    """An executor with its number of workers and the plugins that they load.

    Attributes
    ----------
    executor : Executor or None
        None if calls are made in this process.
    jobs : int
        Number of workers.
    plugins : Plugins
        Plugins that workers outside this process load first.
    why_lost : callable, () -> str
        Returns why no call can return any more because the scheduler is gone; empty while calls can return.
    """

    executor: Executor | None
    jobs: int
    plugins: Plugins = Plugins()
    why_lost: Callable[[], str] = str


class LostExecutorError(SdaeverifyError, BrokenExecutor):
    """An executor that takes no more calls because its workers or its scheduler are lost."""


class Serial(Executor):
    """An executor that makes each call immediately, in this process."""

    def submit(self, fn: Callable[..., Value], /, *args: Any, **kwargs: Any) -> "Future[Value]":
        """Make a call and return its completed future."""
        future: Future[Value] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except FAULTS as error:
            future.set_exception(error)
        return future


@contextmanager
def open_workers(text: str, jobs: int, registry: Registry) -> Iterator[Workers]:
    """Open the executor with a given name and yield its workers.

    Parameters
    ----------
    text : str
        ``NAME``, ``NAME:ADDRESS`` or ``NAME://ADDRESS``.
    jobs : int
        Number of workers; ignored by an executor whose address determines it.
    registry : Registry
        Its plugins are loaded by the workers.

    Raises
    ------
    UsageError
        If no executor has this name, or it cannot be reached.
    """
    name, _, address = text.partition(":")
    known = {entry.name: entry for entry in enabled_entry_points(GROUP)}
    if name not in known:
        names = [PROCESSES, *sorted(known)]
        raise UsageError(f"unknown executor {name!r}{did_you_mean(name, names)} (known: {', '.join(names)})")
    with ExitStack() as opened:
        try:
            given = known[name].load()(address.removeprefix("//"), jobs)
            workers = given.__enter__()
            # Close the executor without passing it errors of the block: they are not its own.
            opened.callback(given.__exit__, None, None, None)
        except UsageError:
            raise
        except ImportError as error:
            raise UsageError(
                f"executor {name} needs a library that is not installed: {one_line(error)}; install it with pip"
            ) from error
        except FAULTS as error:
            raise UsageError(f"executor {text} cannot be used: {one_line(error)}") from error
        yield workers._replace(plugins=Plugins.of(registry))


def serial(_: str, __: int) -> AbstractContextManager[Workers]:
    """Return an executor that runs in this process, for debugging; no limits apply to it."""
    return nullcontext(Workers(Serial(), 1))


@contextmanager
def dask(address: str, jobs: int) -> Iterator[Workers]:
    """Yield the workers of the Dask cluster at an address, or of a local cluster if the address is empty.

    Raises
    ------
    UsageError
        If Dask is not installed.
    """
    try:
        from distributed import Client, LocalCluster  # noqa: PLC0415
    except ModuleNotFoundError as error:
        needed = f"executor dask needs {error.name}, which is not installed"
        raise UsageError(f"{needed}; pip install 'sdaeverify[dask]'") from error
    if address:
        with Client(f"tcp://{address}", timeout=ANSWERS_WITHIN) as client:
            lost = partial(_why_lost, client, f"the scheduler at {address} is dead, or cannot be reached any more")
            yield Workers(client.get_executor(), max(1, sum(client.nthreads().values())), why_lost=lost)
        return
    with (
        LocalCluster(n_workers=jobs, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        yield Workers(client.get_executor(), jobs)


def _why_lost(client: Any, words: str) -> str:
    return "" if client.status == "running" else words


@contextmanager
def crew_of(
    jobs: int, limits: Limits | None, registry: Registry, executor: Executor | str | None = None
) -> Iterator[Workers]:
    """Yield the workers of a run: new processes, those of a named executor, or those of an executor object.

    Parameters
    ----------
    jobs : int
        Number of workers.
    limits : Limits or None
        Limits of new processes.
    registry : Registry
        With the plugins that they load.
    executor : Executor, str or None
        As `verify` takes it.
    """
    if executor is None or executor == PROCESSES:
        with executor_for(jobs, registry.paths, limits, registry.modules) as own:
            yield Workers(own, jobs)
    elif isinstance(executor, str):
        with open_workers(executor, jobs, registry) as crew:
            yield crew
    else:
        yield Workers(executor, jobs, Plugins.of(registry))
