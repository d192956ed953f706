"""One block of an experiment's paths on one problem: every scheme and step size on the same Brownian paths."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ...contracts.matching import match
from ...contracts.scheme import Scheme
from ...contracts.specs import ProblemSpec
from ...errors import FAULTS, SchemeError, one_line
from ...forms import Problem
from ...noise.brownian import Brownian, Piece, Source
from ...simulate.ensemble import one_thread
from ...simulate.tracks import Track
from .notebook import Notebook
from .quantity import Noted, Quantity, Value
from .sample import Sample


@dataclass(frozen=True)
class BlockTask:
    """Everything that determines the samples on one problem; it can be pickled.

    Attributes
    ----------
    spec : ProblemSpec
    quantities : tuple of Quantity
        The numbers of steps of their values are the least one times powers of 2.
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
    problem, runs = task.spec.build(), _values_by_run(task.quantities)
    coarsest = min(steps for _, steps in runs)
    tracks = [_Run(key, values, problem, coarsest, paths) for key, values in runs.items()]
    source = Source(task.seed, task.spec.label, block, task.block, paths)
    areas = any("H" in scheme.noise for scheme, _ in runs)
    finest = max(run.level for run in tracks)
    brownian = Brownian(source, problem.noise_dim, problem.horizon / coarsest, finest, areas)
    for piece in _pieces(brownian, coarsest):
        for run in tracks:
            run.advance(piece)
    noted = {value: found for run in tracks for value, found in run.noted().items()}
    return tuple(quantity.sample(noted) for quantity in task.quantities)


def _values_by_run(quantities: tuple[Quantity, ...]) -> dict[tuple[Scheme, int], list[Value]]:
    found: dict[tuple[Scheme, int], list[Value]] = {}
    for value in dict.fromkeys(value for quantity in quantities for value in quantity.values):
        found.setdefault((value.scheme, value.steps), []).append(value)
    return found


def _pieces(brownian: Brownian, coarsest: int) -> Iterator[Piece]:
    for _, pieces in zip(range(coarsest), brownian.pieces(), strict=False):
        yield from pieces


class _Run:
    """A scheme with one number of steps; what goes wrong in it costs its own values only."""

    def __init__(
        self, key: tuple[Scheme, int], values: Sequence[Value], problem: Problem, coarsest: int, paths: int
    ) -> None:
        (self.scheme, steps), self.problem, self.values, self.error = key, problem, values, ""
        self.level = (steps // coarsest).bit_length() - 1
        self.observers: tuple[Notebook, ...] = ()
        with self._guarded():
            matched = match(self.scheme, problem)
            if matched.problem is None:
                raise SchemeError(matched.reason)
            self.track = Track(self.scheme, matched.problem, self.level, problem.horizon / steps, paths)
            known = [value for value in values if value.observable in problem.observables]
            self.observers = (Notebook(self.track, problem, known),)

    def advance(self, piece: Piece) -> None:
        """Make the steps of a piece of noise of this level."""
        if piece.level == self.level and not self.error:
            with self._guarded():
                self.track.advance(piece.noise, self.observers)

    def noted(self) -> dict[Value, Noted]:
        """Return what was noted, or why nothing was."""
        if self.error:
            return {value: Noted(error=self.error) for value in self.values}
        names = ", ".join(self.problem.observables)
        return {
            value: Noted(error=f"the problem has no observable {value.observable!r}; it has {names}")
            for value in self.values
        } | {value: found for notebook in self.observers for value, found in notebook.noted.items()}

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        try:
            yield
        except FAULTS as error:
            self.error = f"scheme {self.scheme.label}: {one_line(error)}"
