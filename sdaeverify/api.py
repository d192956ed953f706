"""The Python interface: `verify` crosses schemes with problems and returns tables."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypedDict, Unpack

import pandas as pd

from .contracts.measure import Measure
from .contracts.scheme import Scheme
from .contracts.settings import Settings, whole
from .contracts.specs import ProblemSpec
from .errors import UsageError
from .forms import Problem
from .registry.load import Registry, load_registry
from .registry.selection import select_measures, select_problems, select_schemes
from .report.earlier import Kept, save_tables
from .report.files import require_writable
from .report.folders import LEVELS, VERDICTS
from .report.provenance import provenance
from .report.tables import level_table, verdict_rows, verdict_table
from .study import CellResult, Plan, Study, plan
from .study.remote_plan import asking
from .workers.pool import BLOCKS_A_WORKER, executor_for

Schemes = str | Sequence[str | Scheme]
Problems = str | Sequence[str | ProblemSpec | Callable[..., Problem]]
Measures = str | Sequence[str | Measure]


class SettingsOptions(TypedDict, total=False):
    """Keywords of `Settings`."""

    paths: int
    coarsest: int
    levels: int
    seed: int
    confidence: float
    block: int
    looks: int
    family: int


@dataclass(frozen=True)
class Result:
    """Tables of a study.

    Attributes
    ----------
    results : tuple of CellResult
    settings : Settings
    run : dict
        Versions, platform, arguments, seed, stream fingerprint and plugins.
    files : tuple of str
        Plugin files that were named by path.
    unnamed : frozenset of str
        Labels of schemes and problems that are not registered: no command can reproduce their rows.
    """

    results: tuple[CellResult, ...]
    settings: Settings
    run: dict[str, object]
    files: tuple[str, ...] = ()
    unnamed: frozenset[str] = frozenset()

    @cached_property
    def rows(self) -> list[dict[str, object]]:
        """The rows of `verdicts`."""
        return verdict_rows(self.results, self.settings, self.files, self.unnamed)

    @cached_property
    def verdicts(self) -> pd.DataFrame:
        """One row for each quantity of each cell: claim, estimate, interval, verdict, reason, command."""
        return verdict_table(self.rows)

    @cached_property
    def levels(self) -> pd.DataFrame:
        """One row for each quantity of each cell at each step size."""
        return level_table(self.results, self.settings)

    def save(self, folder: str | Path) -> Kept:
        """Write ``verdicts.csv``, ``levels.csv`` and ``run.json`` into a folder.

        Rows on other cells of earlier runs into the folder stay, unless their code has changed.

        Returns
        -------
        Kept
            These rows.

        Raises
        ------
        UsageError
            If the folder cannot be written into.
        """
        target = Path(folder)
        require_writable(target)
        cells = {(r.cell.scheme.label, r.cell.spec.label, r.cell.measure.name) for r in self.results}
        return save_tables(target, {VERDICTS: self.verdicts, LEVELS: self.levels}, self.run, cells)


def verify(
    schemes: Schemes = (),
    problems: Problems = (),
    measures: Measures = (),
    *,
    jobs: int = 1,
    plugins: Sequence[str | Path] = (),
    **settings: Unpack[SettingsOptions],
) -> Result:
    """Cross schemes with problems and judge every claim.

    Parameters
    ----------
    schemes, problems, measures : str or sequence, optional
        Names with parameters or globs as on the command line, or scheme instances, problem functions and
        measures themselves, mixed; everything registered if left out.
    jobs : int, optional
        Worker processes. With more than one, a script needs the usual ``if __name__ == "__main__":``.
    plugins : sequence of str or Path, optional
        Plugin files, beside the installed plugins.
    **settings
        Keywords of `Settings`: paths, coarsest, levels, seed, confidence, block, looks, family.

    Returns
    -------
    Result

    Raises
    ------
    UsageError
        If a name is unknown or a value is out of its range.
    PluginError
        If a plugin file cannot be used.
    """
    chosen, workers = settings_from(**settings), whole("jobs", jobs)
    if workers < 1:
        raise UsageError(f"jobs must be at least 1, got {jobs}")
    registry = load_registry(plugins)
    todo = plan_of(registry, schemes, problems, measures)
    study = Study(todo, chosen)
    with executor_for(workers, registry.files, modules=registry.modules) as executor:
        for _ in study.run(executor, BLOCKS_A_WORKER * workers):
            pass
    return result_of(study, registry, ["sdaeverify.verify"])


def settings_from(**settings: Unpack[SettingsOptions]) -> Settings:
    """Return settings from keywords.

    Raises
    ------
    UsageError
        If a keyword is unknown or a value out of its range.
    """
    known = SettingsOptions.__annotations__
    if unknown := sorted(set(settings) - set(known)):
        raise UsageError(f"unknown setting {', '.join(unknown)}; known are {', '.join(known)}")
    return Settings(**settings)


def plan_of(
    registry: Registry, schemes: Schemes, problems: Problems, measures: Measures, executor: Executor | None = None
) -> Plan:
    """Select and cross; see `verify` for the parameters. Isolated workers are asked what can be run."""
    chosen = (
        select_schemes(registry, schemes),
        select_problems(registry, problems),
        select_measures(registry, measures),
    )
    return plan(*chosen, lambda label: select_schemes(registry, label)[0], asking(executor, *chosen))


def result_of(study: Study, registry: Registry, arguments: Sequence[str]) -> Result:
    """Return what is known of a study, finished or not."""
    run: dict[str, Any] = provenance(registry, study, arguments)
    results = tuple(study.results())
    return Result(results, study.settings, run, registry.files, _unnamed(results, registry))


def _unnamed(results: Sequence[CellResult], registry: Registry) -> frozenset[str]:
    things = (thing for result in results for thing in (result.cell.scheme, result.cell.spec))
    return frozenset(thing.label for thing in things if not registry.names(thing))
