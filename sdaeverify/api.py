"""The Python interface: `verify` crosses schemes with problems and returns tables."""

import logging
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from math import inf, isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import pandas as pd

from .contracts.measure import Measure
from .contracts.opened import openings
from .contracts.scheme import Scheme
from .contracts.settings import Settings, SettingsOptions, number, settings_from, whole
from .contracts.specs import ProblemSpec
from .errors import UsageError
from .forms import Problem
from .registry.foreign_code import same_folder
from .registry.load import Registry, load_registry
from .registry.selection import select_measures, select_problems, select_schemes
from .report.folders import LEVELS, NOT_APPLICABLE, RUN, VERDICTS, key_of, require_run_folder, save_tables
from .report.html import write_page
from .report.notebook import CellView, result_html, result_in_brief, result_text
from .report.paper.citation import ForPapers
from .report.passports import noise_in_words, passports
from .report.plots import Plots
from .report.progress import KINDS
from .report.progress import progress as shown_progress
from .report.provenance import provenance
from .report.saved import settings_of
from .report.tables.choice import Choices, choices, common_basis, curves
from .report.tables.claims import claims_table
from .report.tables.columns import details_file
from .report.tables.command import command_of
from .report.tables.datasets import dataset_of_levels
from .report.tables.rows import Rows, classes_table, records, rows_of, tables_of
from .report.tables.saved_tables import read_result
from .store.store import Store
from .study import Advanced, CellResult, Plan, Study, plan
from .study.class_tests import NO_TESTS, broken_tests, class_results, class_tests
from .study.examination import Work
from .study.trial import trial_of
from .study.unseen import unseen
from .workers.executors import PROCESSES, crew_of
from .workers.limits import Limits, read_limits
from .workers.pool import BLOCKS_A_WORKER

if TYPE_CHECKING:
    import xarray

LOG = logging.getLogger("sdaeverify")
Schemes = str | Scheme | Sequence[str | Scheme]
Problems = str | ProblemSpec | Callable[..., Problem] | Sequence[str | ProblemSpec | Callable[..., Problem]]
Measures = str | Measure | Sequence[str | Measure]


@dataclass(frozen=True, repr=False)
class Result(ForPapers):
    """Tables of a study.

    Attributes
    ----------
    rows : Rows
        The rows of all tables except the levels.
    tables : dict of str to DataFrame
        All tables by the names of their files, with the dictionary of their columns.
    settings : Settings
    run : dict
        Versions, platform, arguments, seed, stream fingerprint and plugins, as ``run.json`` has them.
    results : tuple of CellResult, optional
        The results behind the rows, with schemes and problems; empty for a loaded or pickled result.
    """

    rows: Rows
    tables: dict[str, pd.DataFrame]
    settings: Settings
    run: dict[str, Any]
    results: tuple[CellResult, ...] = ()

    def __reduce__(self) -> tuple[type["Result"], tuple[Any, ...]]:
        return Result, (self.rows, self.tables, self.settings, self.run)

    @property
    def verdicts(self) -> pd.DataFrame:
        """One row for each quantity that is claimed or measured: claim, orders, value, verdict, reason.

        Verdicts are ordered, the worst first: ``verdicts[verdicts.verdict <= "error"]``.
        """
        return self.tables[VERDICTS]

    @property
    def not_applicable(self) -> pd.DataFrame:
        """One row for each cell, or quantity of it, to which its measure does not apply, with the reason."""
        return self.tables[NOT_APPLICABLE]

    def details(self, measure: str) -> pd.DataFrame:
        """Return the additional columns of a measure for its rows of `verdicts`.

        Raises
        ------
        UsageError
            If the result has no rows of the measure.
        """
        if details_file(measure) not in self.tables:
            raise UsageError(f"the result has no rows of measure {measure!r:.200}")
        return self.tables[details_file(measure)]

    def command(self, scheme: str, problem: str, measure: str) -> str:
        """Return the command that computes a cell again; empty if one of its names is not registered.

        Parameters
        ----------
        scheme, problem : str
            Labels.
        measure : str

        Raises
        ------
        UsageError
            If the result has no such cell.
        """
        keys = chain((row.key for row in self.rows.every), map(key_of, self.rows.absent))
        if not any(key[:3] == (scheme, problem, measure) for key in keys):
            raise UsageError(f"the result has no cell of {scheme!r:.200} on {problem!r:.200}, {measure!r:.200}")
        return command_of({"scheme": scheme, "problem": problem, "measure": measure}, self.run)

    @property
    def levels(self) -> pd.DataFrame:
        """One row for each quantity of each cell at each step size."""
        return self.tables[LEVELS]

    @cached_property
    def classes(self) -> pd.DataFrame:
        """One row for each claim about a class of equations, with the verdict of order conditions or random members.

        If the run did not evaluate order conditions, they are evaluated at the first access.

        Raises
        ------
        UsageError
            If the result was loaded or pickled without them, or no plugin tests claims about classes.
        """
        found = self._asked.rows.of_classes
        if not found and not class_tests():
            raise UsageError(NO_TESTS)
        if found is None:
            raise UsageError("the result was saved without its classes; sdaeverify_orders.orders computes them")
        return classes_table(found)

    @property
    def claims(self) -> pd.DataFrame:
        """One row for each claim: its findings by outcome, the worst one. Raises as `classes`."""
        return claims_table(self._asked.rows.every, self.run)

    @cached_property
    def _asked(self) -> "Result":
        """The result with the findings for classes, which are computed if the result still has its schemes."""
        if self.rows.of_classes is not None or not self.results:
            return self
        results = (*self.results, *class_results(self.results, seed=self.settings.seed))
        return _tabled(results, self.settings, self.run, with_classes=True)

    @property
    def plot(self) -> Plots:
        """Pictures of the tables as matplotlib axes: convergence, matrix, orders, work, density, drift and more."""
        return Plots(self.rows.verdicts, records(self.levels), self._details, self.settings.confidence)

    def choose(
        self,
        problem: str,
        measure: str = "strong",
        quantity: str = "",
        accuracy: float = nan,
        progress: str = "none",
    ) -> Choices:
        """Return the schemes for a problem by the work that each needs for an accuracy, the least first.

        Errors are relative to one reference, the truth of the problem or the best verified scheme with finer steps,
        and times are measured on the same arrays, so paths are computed again. For a loaded result, the errors and
        times of its run are used, for verified schemes.

        Parameters
        ----------
        problem : str
            Label.
        measure : str, optional
            Of errors: ``strong``, ``weak`` or ``invariant``.
        quantity : str, optional
            The first one if omitted.
        accuracy : float, optional
            The desired error; if omitted, the error that half of the schemes reach.
        progress : str, optional
            Progress on stderr while paths are computed, as for `verify`.

        Raises
        ------
        UsageError
            If there is no measured error of the quantity.
        """
        if not isnan(number("accuracy", accuracy)) and not 0.0 < accuracy < inf:
            raise UsageError(f"accuracy expects a positive error, got {accuracy!r:.200}")
        known, asked = curves(self.rows.verdicts, records(self.levels), self._details), (measure, quantity)
        with shown_progress(_kind_of_progress(progress)) as show:
            basis = common_basis(self.results, known, problem, asked, self.settings, show)
        return choices(known, problem, asked, self.run.get("noise", {}), accuracy, basis)

    @property
    def _details(self) -> list[dict[str, object]]:
        return [row for rows in self.rows.details.values() for row in rows]

    def cell(self, scheme: str, problem: str) -> CellView:
        """Return a view of the findings on a scheme and a problem.

        Raises
        ------
        UsageError
            If the result has no such cell.
        """
        return CellView.of(self.rows.verdicts, self.rows.absent, scheme, problem)

    def to_xarray(self) -> "xarray.Dataset":
        """Return the verdicts with their levels as an `xarray.Dataset` of dimensions ``row`` and ``h``.

        Rows have the coordinates ``scheme``, ``problem``, ``measure`` and ``quantity``: use
        ``.sel(scheme="milstein", problem="gbm", h=0.125)``. Columns of `verdicts` are variables of the rows; those of
        `levels` of both, NaN or None where there is no level. Densities have a third dimension, ``point``.

        Raises
        ------
        UsageError
            If xarray is not installed.
        """
        return dataset_of_levels(self.verdicts, self.levels)

    def __repr__(self) -> str:
        return result_in_brief(self.rows.verdicts, self.rows.absent, self.settings)

    def __str__(self) -> str:
        return result_text(self.rows.verdicts, self.rows.absent)

    def _repr_html_(self) -> str:
        return result_html(self.rows.verdicts, self.rows.absent)

    def save(self, folder: str | Path) -> None:
        """Write the tables and ``run.json`` into a folder; those of another run are replaced.

        Raises
        ------
        UsageError
            If the folder cannot be written to.
        """
        target = folder_of("save", folder)
        require_run_folder(target, "folder")
        save_tables(target, self._asked.tables, self.run)


class RunOptions(SettingsOptions, total=False):
    """Keyword arguments of `verify` other than schemes, problems and measures."""

    jobs: int
    plugins: Sequence[str | Path]
    progress: str | None
    out: str | Path | None
    timeout: float | None
    memory: str | None
    executor: Executor | str | None


def verify(
    schemes: Schemes = (), problems: Problems = (), measures: Measures = (), **options: Unpack[RunOptions]
) -> Result:
    """Cross schemes with problems and judge every claim.

    Parameters
    ----------
    schemes, problems, measures : str, object or sequence, optional
        Names with parameters or globs as on the command line, or scheme instances, problem functions and
        measures, alone or mixed in a list; all registered ones if omitted.
    jobs : int, optional
        Number of worker processes; 1, the default, means this process. With more than one, or with limits, a script
        needs the usual ``if __name__ == "__main__":``. With `executor`, the number of workers to assume for it.
    executor : Executor or str, optional
        Anything with the interface of `concurrent.futures.Executor`, or the name of one as on the command line
        (``processes``, ``serial``, ``dask``, ``dask://HOST:PORT``, or one of the entry points
        `sdaeverify.executors`). It runs the one-step evaluations and the blocks of paths, in about 2 `jobs` pieces
        per problem, each of at least one scheme. Results are identical to the last bit. Workers need this package but
        no access to this machine's folders: plugin files are sent with each call, evidence is returned as bytes. The
        call of a lost worker is repeated once; `timeout` and `memory` do not apply.
    plugins : sequence of str or Path, optional
        Plugin files, in addition to the installed plugins.
    progress : str, optional
        On stderr: ``auto`` for a bar on a terminal and lines elsewhere, ``plain``, or ``none`` (the default).
    out : str or Path, optional
        Folder for tables, evidence and page, as for ``matrix --out``; evidence in it is reused.
    timeout : float, optional
        Maximum seconds for a scheme on a block of paths; 0 for no limit. Default 600 if there are worker processes.
    memory : str, optional
        Maximum memory of a worker, such as ``2G``; ``0`` for no limit.
    **options
        Keywords of `Settings`: paths, coarsest, levels (a number, or steps as ``16..256``), first_levels (4; as many
        as levels where these are given), seed, confidence, block, max_looks, tests_reserved.

    Returns
    -------
    Result

    Raises
    ------
    UsageError
        If a name is unknown or a value is out of its range.
    PluginError
        If a plugin file cannot be used.
    LostExecutorError
        If the executor accepts no more calls, or loses one twice; evidence received so far is in `out`.
    """
    for kind, given in (("schemes", schemes), ("problems", problems), ("measures", measures)):
        if isinstance(given, list) and not given:
            # An empty list is likely a program's failed search and must not select everything.
            raise UsageError(f"an empty list of {kind}; leave {kind} out to select all of them")
    numbers: dict[str, Any] = dict(options)
    asked = {name: numbers.pop(name, default) for name, default in WITHOUT_OPTIONS.items()}
    limits, settings = _check_options(**asked), settings_from(**numbers)
    if asked["out"] is not None and limits is None:
        openings()  # This process simulates for a store: evidence depends on files that plugins open.
    registry = load_registry(asked["plugins"])
    for warning in (*registry.complaints, *(broken_tests() if asked["out"] is not None else ())):
        LOG.warning(warning)
    folder = None if asked["out"] is None else Path(asked["out"])
    if folder is not None:
        require_run_folder(folder, "out")
    with crew_of(asked["jobs"], limits, registry, asked["executor"]) as crew:
        todo = plan_of(registry, schemes, problems, measures, crew.executor if limits else None)
        study = Study(todo, settings, None if folder is None else Store(folder), orders=folder is not None)
        LOG.info("%d cells of %d problems are planned", len(todo.cells), len(todo.problems))
        with shown_progress(_kind_of_progress(asked["progress"])) as show:
            for event in study.run(crew, BLOCKS_A_WORKER * crew.jobs):
                _log(event)
                show(event)
    result = result_of(study, registry, ["sdaeverify.verify"])
    if folder is not None:
        result.save(folder)
        write_page(folder, passports(todo))
    return result


def _log(event: Advanced) -> None:
    if event.results:
        LOG.info("%s is finished: %d cells", event.problem, len(event.results))


WITHOUT_OPTIONS: dict[str, Any] = {"jobs": 1, "plugins": ()} | dict.fromkeys(
    ("progress", "out", "timeout", "memory", "executor")
)


def _check_options(
    *, jobs: Any, progress: Any, out: Any, timeout: Any, memory: Any, executor: Any, **_: object
) -> Limits | None:
    """Check the options of `verify` that are not settings, and return the limits of its worker processes."""
    if whole("jobs", jobs) < 1:
        raise UsageError(f"jobs must be at least 1, got {jobs}")
    _kind_of_progress(progress)
    if out is not None:
        folder_of("out", out)
    if memory is not None and not isinstance(memory, str):
        raise UsageError(f"memory must be a size such as '2G', got {memory!r:.200}")
    if not (executor is None or isinstance(executor, str) or callable(getattr(executor, "submit", None))):
        raise UsageError(f"executor expects a name or an object with a method submit, got {executor!r:.200}")
    limited = timeout is not None or memory is not None
    if not (executor is None or executor == PROCESSES):
        if limited:
            raise UsageError(
                "timeout and memory apply to worker processes only; leave them out with another executor"
            )
        return None
    seconds = None if timeout is None else number("timeout", timeout)
    return read_limits(seconds, memory, jobs)[1] if limited or jobs > 1 else None


def plan_of(
    registry: Registry, schemes: Schemes, problems: Problems, measures: Measures, executor: Executor | None = None
) -> Plan:
    """Select and cross schemes, problems and measures; isolated workers try which cells can be run.

    Parameters
    ----------
    registry : Registry
    schemes, problems, measures : str, object or sequence of them
        As for `verify`.
    executor : Executor or None
        Workers for the trials; this process if None.
    """
    chosen = (
        select_schemes(registry, schemes),
        select_problems(registry, problems),
        select_measures(registry, measures),
    )
    trial = trial_of(executor, *chosen)
    # Planning makes steps of schemes.
    with same_folder():
        return plan(*chosen, lambda label: select_schemes(registry, label)[0], trial, registry.followed)


def result_of(study: Study, registry: Registry, arguments: Sequence[str], beside: Sequence[Work] = ()) -> Result:
    """Return the result of a study, finished or not.

    Parameters
    ----------
    study : Study
        Its results so far are used.
    registry : Registry
    arguments : sequence of str
        The call, for the record of the run.
    beside : sequence of Work, optional
        Finished examinations.
    """
    run: dict[str, Any] = provenance(registry, study, arguments)
    results = tuple(study.results())
    things = {id(thing): thing for result in results for thing in (result.cell.scheme, result.cell.spec)}
    run["noise"] = {each.label: noise_in_words(each) for each in things.values() if isinstance(each, Scheme)}
    run["unnamed"] = sorted({thing.label for thing in things.values() if not registry.names(thing)})
    run["unseen"] = [*unseen(study.plan)]
    examined = [(result, work.command) for work in beside for result in work.results]
    run["examined"] = {result.cell.measure.name: [*words] for result, words in examined}
    results += tuple(result for result, _ in examined)
    results += study.class_results or ()
    return _tabled(results, study.settings, run, with_classes=study.class_results is not None)


def _tabled(found: tuple[CellResult, ...], settings: Settings, run: dict[str, Any], *, with_classes: bool) -> Result:
    rows = rows_of(found, with_classes=with_classes)
    return Result(rows, tables_of(rows, found, settings), settings, run, found)


def load(folder: str | Path) -> Result:
    """Return the result that a run of `verify` or of ``matrix`` has saved in a folder.

    Parameters
    ----------
    folder : str or Path
        With ``verdicts.csv`` and ``run.json``. Texts are read, no code is executed.

    Raises
    ------
    UsageError
        If the folder holds no run, or one of another version of this program.
    """
    place = folder_of("load", folder)
    rows, tables, run = read_result(place)
    return Result(rows, tables, settings_of(run, place / RUN), run)


def folder_of(name: str, given: object) -> Path:
    """Return a folder named by the user, after checking its type.

    Parameters
    ----------
    name : str
        Of the argument or function, for messages.
    given : object

    Raises
    ------
    UsageError
        If it is not a path, or is empty, which would mean the current folder.
    """
    if not isinstance(given, str | Path) or not str(given).strip():
        raise UsageError(f"{name} expects a folder, got {given!r:.200}")
    return Path(given)


def _kind_of_progress(progress: str | None) -> str:
    """Return the kind of progress display, ``none`` for None; raise UsageError if it is unknown."""
    if progress not in {None, *KINDS}:
        raise UsageError(f"progress must be one of {', '.join(KINDS)}, got {progress!r:.200}")
    return progress or "none"
