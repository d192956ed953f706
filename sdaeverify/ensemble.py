"""The only time loop: all schemes and step sizes of a problem in lockstep on the same noise, block by block.

Noise lives for a few steps, states for one: memory depends neither on the number of steps nor on the number of paths.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .errors import FAULTS, SchemeError, one_line
from .forms import Problem
from .lanes import Lane, Moments, Observer, parts_of
from .matching import match
from .measure import Measure
from .noise import Brownian, Piece, Source
from .reference import Reference
from .scheme import Scheme
from .settings import Settings
from .specs import ProblemSpec
from .tally import Tally


@dataclass(frozen=True)
class Entry:
    """A scheme with the measures that are put to it."""

    scheme: Scheme
    measures: tuple[Measure, ...]


@dataclass(frozen=True)
class Task:
    """Everything that determines the evidence on one problem; it can be pickled."""

    spec: ProblemSpec
    entries: tuple[Entry, ...]
    settings: Settings


class LaneEvidence(NamedTuple):
    """Evidence on one scheme.

    Attributes
    ----------
    tallies : tuple of Tally
        One for each measure.
    health : Tally
        Failed paths, lost paths, truncated steps and steps of each level.
    seconds : float
    error : str
        Why there is no evidence; empty if there is.
    """

    tallies: tuple[Tally, ...]
    health: Tally
    seconds: float
    error: str

    def merged(self, other: "LaneEvidence") -> "LaneEvidence":
        """Return the evidence of both; the first error stays."""
        return LaneEvidence(
            tuple(a.merged(b) for a, b in zip(self.tallies, other.tallies, strict=True)),
            self.health.merged(other.health),
            self.seconds + other.seconds,
            self.error or other.error,
        )


def run_block(task: Task, block: int) -> tuple[LaneEvidence, ...]:
    """Simulate one block of paths, in a worker process or in this one.

    Parameters
    ----------
    task : Task
    block : int
        Index of the block.

    Returns
    -------
    tuple of LaneEvidence
        One for each entry of the task.
    """
    try:
        # Non-finite numbers are evidence here: they are counted, not warned about.
        with np.errstate(all="ignore"):
            return _run_block(task, block)
    except FAULTS as error:
        reason = f"problem {task.spec.label}: {one_line(error)}"
        return tuple(_without_evidence(entry, 0.0, reason) for entry in task.entries)


def _run_block(task: Task, block: int) -> tuple[LaneEvidence, ...]:
    problem = task.spec.build()
    reference = Reference(problem, task.settings, task.settings.paths_of(block))
    runs = [_Run(entry, problem, reference, task.settings) for entry in task.entries]
    if any(run.observers for run in runs):
        source = Source(task.settings.seed, task.spec.label, block, task.settings.block, reference.paths)
        _simulate(problem, reference, runs, source)
    return tuple(run.evidence(first=block == 0) for run in runs)


def _without_evidence(entry: Entry, seconds: float, error: str) -> LaneEvidence:
    return LaneEvidence(tuple(Tally() for _ in entry.measures), Tally(), seconds, error)


def _simulate(problem: Problem, reference: Reference, runs: "Sequence[_Run]", source: Source) -> None:
    coarsest = runs[0].settings.coarsest
    extra = source.stream("truth", reference.level)
    areas = "H" in problem.noise
    brownian = Brownian(source, problem.noise_dim, problem.horizon / coarsest, reference.finest, areas)
    for _, pieces in zip(range(coarsest), brownian.pieces(), strict=False):
        for piece in pieces:
            reference.advance(piece, extra)
            for run in runs:
                run.advance(piece)
        for run in runs:
            run.note()


class _Run:
    """A lane with its observers; what goes wrong in it costs this lane only."""

    def __init__(self, entry: Entry, problem: Problem, reference: Reference, settings: Settings) -> None:
        self.entry, self.reference, self.settings = entry, reference, settings
        self.error, self.seconds = "", 0.0
        self.noted: list[Observer | None] = []
        self.observers: list[Observer] = []
        with self._guard():
            self._begin(problem)

    def _begin(self, problem: Problem) -> None:
        scheme, paths = self.entry.scheme, self.reference.paths
        matched = match(scheme, problem)
        if matched.problem is None:
            raise SchemeError(matched.reason)
        self.view = matched.problem
        parts = parts_of(scheme.start(self.view, paths), self.view)
        self.noted = [measure.observer(problem, parts, self.settings) for measure in self.entry.measures]
        self.observers = [observer for observer in self.noted if observer is not None]
        self.lane = Lane(scheme, self.view, self.settings.steps, paths, self.reference.own)

    def advance(self, piece: Piece) -> None:
        """Make the steps of a piece of noise, unless something went wrong before."""
        if not self.error and self.observers:
            with self._guard():
                self.lane.advance(piece, self.observers)

    def note(self) -> None:
        """Show the observers where the lane and the truth are at the end of a coarsest step."""
        if self.error or not self.observers:
            return
        with self._guard():
            levels, own = self.lane.parts()
            truth = self.reference.parts() if own is None else [own]
            moments = Moments(levels, truth[0], truth[1] if len(truth) > 1 else None)
            for observer in self.observers:
                observer.after_coarsest_step(moments)

    def evidence(self, *, first: bool) -> LaneEvidence:
        """Return what was noted; the first block also evaluates the one-step map where a measure asks for it."""
        tallies: tuple[Tally, ...] = ()
        if not self.error:
            with self._guard():
                tallies = tuple(self._tallies(first=first))
        if self.error:
            return _without_evidence(self.entry, self.seconds, self.error)
        return LaneEvidence(tallies, self.lane.health(), self.seconds, "")

    def _tallies(self, *, first: bool) -> Iterator[Tally]:
        for measure, observer in zip(self.entry.measures, self.noted, strict=True):
            noted = Tally() if observer is None else observer.tally()
            yield noted.merged(measure.probe(self.entry.scheme, self.view, self.settings)) if first else noted

    def _guard(self) -> "_Guard":
        return _Guard(self)


class _Guard:
    """Time a piece of work and keep what a plugin raises as the reason of its own cells."""

    def __init__(self, run: _Run) -> None:
        self.run = run

    def __enter__(self) -> None:
        self.begun = time.perf_counter()

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> bool:
        self.run.seconds += time.perf_counter() - self.begun
        if isinstance(error, FAULTS):
            self.run.error = one_line(error)
            return True
        return False
