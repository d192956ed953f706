"""What the uniform measure notes on one block, and the quantities it is about."""

from collections.abc import Container, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...arrays import Parts
from ...contracts.measure import Evidence, Snapshot
from ...contracts.settings import Settings
from ...contracts.tally import Tally
from ...forms import Problem
from ..path_errors.errors import POWERS, ErrorObserver
from ..path_errors.quantity import Quantity, quantities_of
from .continuous import CONTINUOUS, ContinuousErrors

ON_GRID, IN_TIME = " on the grid", " in continuous time"


class UniformObserver:
    """Notes errors on the coarsest grid against the truth, and between grid points against the finest level."""

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.grid = ErrorObserver(parts, settings, len(POWERS))
        self.between = ContinuousErrors(parts, _known(problem, parts), settings)

    @property
    def wanted(self) -> Sequence[Container[int]]:
        """Steps of each level that are noted between grid points."""
        return self.between.wanted

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Note the components between grid points."""
        self.between.after_step(level, step, parts)

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Note the errors on the grid."""
        self.grid.after_coarsest_step(snapshot)

    def tally(self) -> Tally:
        """Return the sums of both."""
        return self.grid.tally(at_end=False).merged(self.between.tally())


def pairs_of(evidence: Evidence) -> Iterator[tuple[str, Quantity, Quantity]]:
    """Yield each component with its quantity on the grid and in continuous time."""
    for grid in quantities_of(evidence):
        error = evidence.tally.sums[f"{CONTINUOUS} {grid.name}"]
        between = replace(
            grid,
            name=f"{grid.name}{IN_TIME}",
            error=error,
            difference=np.empty((len(error), 0, len(POWERS))),
            blurred=None,
            largest=evidence.tally.largest[f"{CONTINUOUS} {grid.name}"][..., : evidence.settings.extremes],
        )
        yield grid.name, replace(grid, name=f"{grid.name}{ON_GRID}"), between


def _known(problem: Problem, parts: Parts) -> list[str]:
    """Return the components that the truth knows; all of them where a scheme is its own reference."""
    truth = problem.pathwise
    return [name for name in parts if truth is None or name in truth.parts(0.0, truth.start(1))]
