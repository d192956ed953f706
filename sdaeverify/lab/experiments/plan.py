"""What an experiment runs: its labels resolved, the rows of a problem together, so that they share their noise."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from ...contracts.experiment import Experiment, Row
from ...contracts.scheme import Scheme
from ...contracts.settings import Settings
from ...contracts.specs import ProblemSpec, unknown
from ...errors import UsageError
from ...registry.load import Registry
from ...registry.selection import select_problems, select_schemes
from .block import BlockTask
from .quantity import Quantity, Value

Thing = TypeVar("Thing")


@dataclass(frozen=True)
class ExperimentPlan:
    """An experiment that can be run.

    Attributes
    ----------
    experiment : Experiment
    groups : tuple of (BlockTask, tuple of Row)
        One for each problem: what is simulated, and the row of each of its quantities.
    paths, seed : int
    """

    experiment: Experiment
    groups: tuple[tuple[BlockTask, tuple[Row, ...]], ...]
    paths: int
    seed: int

    @property
    def rows(self) -> tuple[Row, ...]:
        """The rows that are run, in the experiment's order."""
        chosen = {row for _, rows in self.groups for row in rows}
        return tuple(row for row in self.experiment.rows if row in chosen)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of paths of each block."""
        block = self.experiment.block
        whole, rest = divmod(self.paths, block)
        return (block,) * whole + ((rest,) if rest else ())

    def jobs(self) -> Iterator[tuple[int, int]]:
        """Yield (group, block), all problems of a block first: an interrupt finds as many paths of each."""
        for block in range(len(self.sizes)):
            for group in range(len(self.groups)):
                yield group, block


def experiment_plan(
    registry: Registry, name: str, *, paths: int | None = None, seed: int | None = None, every: bool = False
) -> ExperimentPlan:
    """Resolve the labels of an experiment.

    Parameters
    ----------
    registry : Registry
    name : str
    paths, seed : int, optional
        By default the experiment's number, and the seed of `Settings`.
    every : bool
        Whether rows that are costly are run, too.

    Raises
    ------
    UsageError
        If the experiment, or a scheme or problem of it, is not registered, or there are fewer than 2 paths.
    """
    if name not in registry.experiments:
        raise unknown("experiment", name, registry.experiments)
    experiment = registry.experiments[name].experiment
    paths = experiment.paths if paths is None else paths
    if paths < 2:
        raise UsageError(f"paths must be at least 2, or there is no standard error, got {paths}")
    seed = Settings(seed=Settings().seed if seed is None else seed).seed
    rows = [row for row in experiment.rows if every or not row.costly]
    groups = []
    for problem in dict.fromkeys(row.problem for row in rows):
        chosen = tuple(row for row in rows if row.problem == problem)
        quantities = tuple(_quantity(registry, row) for row in chosen)
        groups.append((BlockTask(_problem(registry, problem), quantities, seed, experiment.block), chosen))
    return ExperimentPlan(experiment, tuple(groups), paths, seed)


def _quantity(registry: Registry, row: Row) -> Quantity:
    value = Value(_scheme(registry, row.scheme), row.steps, row.observable, row.steps_made)
    if row.reference is None:
        return Quantity(value)
    label, steps = row.reference
    at = row.steps_made * (steps // row.steps)
    return Quantity(value, Value(_scheme(registry, label), steps, row.observable, at))


def _scheme(registry: Registry, label: str) -> Scheme:
    return _one("scheme", label, select_schemes(registry, [label]))


def _problem(registry: Registry, label: str) -> ProblemSpec:
    return _one("problem", label, select_problems(registry, [label]))


def _one(kind: str, label: str, found: Sequence[Thing]) -> Thing:
    if len(found) != 1:
        raise UsageError(f"an experiment names one {kind}, and {label!r} names {len(found)}")
    return found[0]
