"""One block of an experiment's paths on one problem: every scheme and step size on the same Brownian paths."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..ensemble import one_thread
from ..errors import FAULTS, SchemeError, one_line
from ..forms import Problem
from ..lanes import Track
from ..matching import match
from ..noise import Brownian, Piece, Source
from ..scheme import Scheme
from ..specs import ProblemSpec
from .sample import Sample


class Quantity(NamedTuple):
    """The mean of an observable at the final time, by a scheme with a number of steps."""

    scheme: Scheme
    steps: int
    observable: str


@dataclass(frozen=True)
class BlockTask:
    """Everything that determines the samples on one problem; it can be pickled.

    Attributes
    ----------
    spec : ProblemSpec
    quantities : tuple of Quantity
        Their numbers of steps are the least one times powers of 2.
    seed : int
    block : int
        Paths of a full block.
    """

    spec: ProblemSpec
    quantities: tuple[Quantity, ...]
    seed: int
    block: int


def run_block(task: BlockTask, block: int, paths: int) -> tuple[Sample, ...]:
    """Simulate one block of paths, in a worker process or in this one.

    Parameters
    ----------
    task : BlockTask
    block : int
        Index of the block.
    paths : int
        How many of its paths are used.

    Returns
    -------
    tuple of Sample
        One for each quantity.
    """
    try:
        # A path that is lost is counted, not warned about.
        with np.errstate(all="ignore"), one_thread():
            return _run_block(task, block, paths)
    except FAULTS as error:
        return tuple(Sample(error=f"problem {task.spec.label}: {one_line(error)}") for _ in task.quantities)


def _run_block(task: BlockTask, block: int, paths: int) -> tuple[Sample, ...]:
    problem, coarsest = task.spec.build(), min(quantity.steps for quantity in task.quantities)
    keys = dict.fromkeys((quantity.scheme, quantity.steps) for quantity in task.quantities)
    runs = {key: _Run(*key, problem, coarsest, paths) for key in keys}
    source = Source(task.seed, task.spec.label, block, task.block, paths)
    finest = max(run.level for run in runs.values())
    areas = any("H" in scheme.noise for scheme, _ in keys)
    brownian = Brownian(source, problem.noise_dim, problem.horizon / coarsest, finest, areas)
    for piece in _pieces(brownian, coarsest):
        for run in runs.values():
            run.advance(piece)
    return tuple(runs[scheme, steps].sample(observable) for scheme, steps, observable in task.quantities)


def _pieces(brownian: Brownian, coarsest: int) -> Iterator[Piece]:
    for _, pieces in zip(range(coarsest), brownian.pieces(), strict=False):
        yield from pieces


class _Run:
    """A scheme with one number of steps; what goes wrong in it costs its own quantities only."""

    def __init__(self, scheme: Scheme, steps: int, problem: Problem, coarsest: int, paths: int) -> None:
        self.scheme, self.problem, self.error = scheme, problem, ""
        self.level = (steps // coarsest).bit_length() - 1
        with self._guarded():
            matched = match(scheme, problem)
            if matched.problem is None:
                raise SchemeError(matched.reason)
            self.track = Track(scheme, matched.problem, self.level, problem.horizon / steps, paths)

    def advance(self, piece: Piece) -> None:
        """Make the steps of a piece of noise of this level."""
        if piece.level == self.level and not self.error:
            with self._guarded():
                self.track.advance(piece.noise, ())

    def sample(self, observable: str) -> Sample:
        """Return the observable at the final time."""
        if self.error:
            return Sample(error=self.error)
        known = self.problem.observables
        if observable not in known:
            return Sample(error=f"the problem has no observable {observable!r}; it has {', '.join(known)}")
        self.track.find_lost(0.0)
        values = known[observable](self.problem.horizon, self.track.parts())
        # What is lost has no value, also where an observable gives it a finite one.
        values = np.where(self.track.lost, np.nan, values)
        return Sample.of(values, int(self.track.failed.sum()), int(self.track.lost.sum()))

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        try:
            yield
        except FAULTS as error:
            self.error = f"scheme {self.scheme.label}: {one_line(error)}"
