"""All schemes and step sizes of a problem in lockstep on the same noise, block by block.

Noise lives for a few steps, states for one: memory depends neither on the number of steps nor on the number of paths.
"""

import os
import time
from collections.abc import Container, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from typing import NamedTuple

import numpy as np
from threadpoolctl import ThreadpoolController

from ..arrays import Parts
from ..conformance import compared_steps, violation
from ..contracts.matching import match
from ..contracts.measure import Followed, Measure, Observer, Snapshot, rests_on_moments
from ..contracts.scheme import Scheme
from ..contracts.settings import SCREENING, Settings
from ..contracts.specs import ProblemSpec, built
from ..contracts.tally import Tally, packed
from ..errors import FAULTS, SchemeError, is_out_of_memory, with_traceback
from ..forms import Problem
from ..noise.brownian import Brownian, Piece, Source
from ..probe.explosion import NAME, explosion
from .reference import Reference
from .tracks import SchemeTracks, follow

# Bytes, just below the largest block whose return teaches glibc to keep smaller ones.
LARGE_BLOCK = 2**25 - 2**16

# In place of the index of a scheme: the problem itself, with its truth.
PROBLEM = -1
# In place of the index of a measure: none of them, but the scheme.
NO_MEASURE = -1


@contextmanager
def alone() -> Iterator[None]:
    """End a copy of this process that the code inside has made by ``fork``: one alone comes back."""
    process = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != process:
            os._exit(1)


class Marker:
    """Is told whose code runs, so that a process that hangs or dies can be blamed on somebody; it sets no limits."""

    @contextmanager
    def of(self, scheme: int) -> Iterator[None]:  # noqa: ARG002 - nobody is watched here
        """Run code of a scheme, by its index among those of the block, or of the problem."""
        with alone():
            yield

    @contextmanager
    def measure(self, index: int) -> Iterator[None]:  # noqa: ARG002
        """Run code of a measure, by its index among those put to the scheme."""
        yield


class Behaviour(NamedTuple):
    """What a scheme and a problem do, as digests of their results at fixed arguments."""

    scheme: str
    problem: str


@dataclass(frozen=True)
class Entry:
    """A scheme with the measures that are put to it."""

    scheme: Scheme
    measures: tuple[Measure, ...]


@dataclass(frozen=True)
class Task:
    """Everything that determines the evidence on one problem; it can be pickled.

    Attributes
    ----------
    spec : ProblemSpec
    entries : tuple of Entry
    settings : Settings
    screened : bool
        Whether one step is looked at before there are paths, as a block of its own; if not, with the first paths.
    stage : int
        How many levels paths take beyond those of the settings; see `Settings.stages`.
    followed : Followed or None
        Names of the measures whose claims say that steps follow the equation; None for those of the entries.
    """

    spec: ProblemSpec
    entries: tuple[Entry, ...]
    settings: Settings
    screened: bool = False
    stage: int = 0
    followed: Followed | None = None

    @property
    def label(self) -> str:
        """Label of the problem."""
        return self.spec.label

    @property
    def following(self) -> Followed:
        """Names of the measures whose claims say that steps follow the equation."""
        return self.followed or Followed.by(measure for entry in self.entries for measure in entry.measures)

    def only(self, entries: Sequence[Entry]) -> "Task":
        """Return the task with some of its entries, or with some of their measures."""
        return replace(self, entries=tuple(entries))

    @property
    def sampled(self) -> Settings:
        """The settings that paths are drawn with; one step is looked at with those of the whole run."""
        return self.settings.at(self.stage)


class SchemeEvidence(NamedTuple):
    """Evidence on one scheme.

    Attributes
    ----------
    tallies : tuple of Tally
        What was sampled, one for each measure.
    probes : tuple of Tally
        What was found without sampling, one for each measure; in the first block or the screening only.
    health : Tally
        Failed paths, lost paths, truncated steps and steps of each level.
    seconds : float
    errors : tuple of str
        Why there is no evidence, one for each measure, in a line with a traceback below it; empty if there is.
    paths : int
    violation : str
        Which contract the scheme breaks, so that nothing was measured; empty if none.
    behaviour : Behaviour or None
        What scheme and problem did before and after; None if nobody asked.
    starved : frozenset of int
        The measures whose error is that there was no memory left.
    opened : tuple of (str, str)
        Files that the code of scheme, problem and measures had opened, with hashes of what they held.
    """

    tallies: tuple[Tally, ...]
    probes: tuple[Tally, ...]
    health: Tally
    seconds: float
    errors: tuple[str, ...]
    paths: int = 0
    violation: str = ""
    behaviour: Behaviour | None = None
    starved: frozenset[int] = frozenset()
    opened: tuple[tuple[str, str], ...] = ()


def run_block(task: Task, block: int, marker: Marker | None = None) -> tuple[SchemeEvidence, ...]:
    """Simulate one block of paths, in a worker process or in this one.

    Parameters
    ----------
    task : Task
    block : int
        Index of the block, or `SCREENING` for what needs no paths.
    marker : Marker, optional
        Is told whose code runs.

    Returns
    -------
    tuple of SchemeEvidence
        One for each entry of the task.
    """
    try:
        _keep_freed_memory()
        # Non-finite numbers are evidence here: they are counted, not warned about.
        with np.errstate(all="ignore"), one_thread():
            return _run_block(task, block, marker or Marker())
    except FAULTS as error:
        reason = f"problem {task.spec.label}: {with_traceback(error)}"
        starved = is_out_of_memory(error)
        return tuple(without_evidence(entry, reason, starved=starved) for entry in task.entries)


def one_thread() -> AbstractContextManager[object]:
    """Hold linear algebra to one thread: sums depend on how many there are, and workers would fight for the cores."""
    limited: AbstractContextManager[object] = _threads().limit(limits=1)
    return limited


@cache
def _threads() -> ThreadpoolController:
    # Only what is loaded is held: scipy brings linear algebra of its own.
    import_module("scipy.linalg")
    return ThreadpoolController()


def _keep_freed_memory() -> None:
    """Let glibc, which learns from what it gives back, keep the arrays of a step: fetching them anew takes time."""
    np.empty(LARGE_BLOCK, dtype=np.uint8)


def _run_block(task: Task, block: int, marker: Marker) -> tuple[SchemeEvidence, ...]:
    with marker.of(PROBLEM):
        problem = built(task.spec)
        asked_for = any(_needs_truth(entry, problem) for entry in task.entries)
        reference = Reference(problem, task.sampled, max(block, 0), asked_for=asked_for)
    first = block == (SCREENING if task.screened else 0)
    place = _Place(problem, reference, task, marker, first=first, sampled=block != SCREENING)
    runs = [_Run(entry, index, place) for index, entry in enumerate(task.entries)]
    if any(run.sampled for run in runs):
        source = Source(task.settings.seed, task.spec.label, block, reference.drawn, reference.paths)
        _simulate(place, runs, source)
    return tuple(run.evidence() for run in runs)


def _needs_truth(entry: Entry, problem: Problem) -> bool:
    whose = "scheme" if problem.pathwise is None else "problem"
    return any(whose in measure.truths for measure in entry.measures)


def without_evidence(
    entry: Entry, error: str, seconds: float = 0.0, violation: str = "", *, starved: bool = False
) -> SchemeEvidence:
    """Return that nothing is known of a scheme, and why.

    Parameters
    ----------
    entry : Entry
        The scheme, and what should have been measured of it.
    error : str
        Why, in a line.
    seconds : float
        What it took until it was known.
    violation : str
        How its steps break their contract; empty if they do not.
    starved : bool
        Whether memory was short, so that less at once may succeed.
    """
    nothing = tuple(Tally() for _ in entry.measures)
    errors, measures = tuple(error for _ in entry.measures), range(len(entry.measures) if starved else 0)
    return SchemeEvidence(
        nothing, nothing, Tally(), seconds, errors, violation=violation, starved=frozenset(measures)
    )


class _Place(NamedTuple):
    """What all schemes of a block share."""

    problem: Problem
    reference: Reference
    task: Task
    marker: Marker
    first: bool
    sampled: bool


def _simulate(place: _Place, runs: "Sequence[_Run]", source: Source) -> None:
    problem, reference, coarsest = place.problem, place.reference, place.task.settings.coarsest
    extra = source.stream("truth", reference.level)
    h = problem.horizon / coarsest
    brownian = Brownian(source, problem.noise_dim, h, reference.finest, problem.noise, problem.records)

    def advance(piece: Piece) -> None:
        with place.marker.of(PROBLEM):
            reference.advance(piece, extra)
        for run in runs:
            run.advance(piece)

    def note() -> None:
        for run in runs:
            run.note()

    follow(brownian, coarsest, advance, note)


class _Watch:
    """One measure on one scheme; what goes wrong in it costs this measure only."""

    def __init__(self, measure: Measure, index: int, place: _Place, parts: Parts | None) -> None:
        problem, settings = place.problem, place.task.sampled
        self.measure, self.index, self.marker, self.error, self.starved = measure, index, place.marker, "", False
        self.observer: Observer | None = None
        self.wanted: Sequence[Container[int]] = [frozenset()] * settings.levels
        if parts is None:
            return
        with self.catch_errors():
            self.observer = measure.observer(problem, parts, settings)
            if self.observer is not None:
                self.wanted = self.observer.wanted

    @contextmanager
    def catch_errors(self) -> Iterator[None]:
        """Keep what the measure raises as its reason; nothing more is noted then."""
        try:
            with self.marker.measure(self.index):
                yield
        except FAULTS as error:
            if not self.error:
                self.error = f"measure {self.measure.name}: {with_traceback(error)}"
                self.starved = is_out_of_memory(error)
            self.observer = None

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Pass on what is noted."""
        if self.observer is not None:
            with self.catch_errors():
                self.observer.after_step(level, step, parts)

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Pass on what is noted."""
        if self.observer is not None:
            with self.catch_errors():
                self.observer.after_coarsest_step(snapshot)

    def tally(self) -> Tally:
        """Return what was noted."""
        noted = Tally()
        if self.observer is not None:
            with self.catch_errors():
                noted = self.observer.tally()
        return noted


class _Run:
    """A scheme on one block; what goes wrong in it costs this scheme only."""

    def __init__(self, entry: Entry, index: int, place: _Place) -> None:
        self.entry, self.index, self.place = entry, index, place
        self.reference, self.settings, self.followed = place.reference, place.task.settings, place.task.following
        self.error, self.starved, self.violation, self.seconds = "", False, "", 0.0
        self.watches: list[_Watch] = []
        with self._catch_errors():
            self._begin()

    def _begin(self) -> None:
        scheme, paths = self.entry.scheme, self.reference.paths
        matched = match(scheme, self.place.problem)
        if matched.problem is None:
            raise SchemeError(matched.reason)
        self.view = matched.problem
        self.violation = violation(scheme, self.view, followed=self.followed) if self.place.first else ""
        if self.violation:
            return
        parts = None
        if self.place.sampled:
            own = self.reference.own if _needs_truth(self.entry, self.place.problem) else None
            self.tracks = SchemeTracks(scheme, self.view, self.place.task.sampled, paths, own)
            parts = self.tracks.tracks[0].constraint_arguments()
        self.watches = [_Watch(m, index, self.place, parts) for index, m in enumerate(self.entry.measures)]

    @property
    def sampled(self) -> bool:
        """Whether there is something to note and nothing has gone wrong."""
        return not self.error and any(watch.observer for watch in self.watches)

    def advance(self, piece: Piece) -> None:
        """Make the steps of a piece of noise."""
        if self.sampled:
            with self._catch_errors():
                self.tracks.advance(piece, self.watches)

    def note(self) -> None:
        """Show the observers where the scheme and the truth are at the end of a coarsest step."""
        if self.sampled:
            with self._catch_errors():
                self.tracks.find_ended(self.place.problem)
                snapshot = self.tracks.snapshot(self.reference.parts())
                for watch in self.watches:
                    watch.after_coarsest_step(snapshot)

    def evidence(self) -> SchemeEvidence:
        """Return what was noted, and what the one-step map tells where a measure asks for it before all paths."""
        tallies: list[Tally] = []
        probes: list[Tally] = []
        if not (self.error or self.violation):
            with self._catch_errors():
                if self.place.sampled:
                    self.tracks.repeat_first_steps()
                tallies = [watch.tally() for watch in self.watches]
                probes = [self._probe(watch) for watch in self.watches]
        if self.error or self.violation:
            return without_evidence(self.entry, self.error, self.seconds, self.violation, starved=self.starved)
        errors = tuple(watch.error for watch in self.watches)
        return SchemeEvidence(
            tuple(tallies),
            tuple(probes),
            self.tracks.health() if self.place.sampled else Tally(),
            self.seconds,
            errors,
            self.reference.paths if self.place.sampled else 0,
            starved=frozenset(index for index, watch in enumerate(self.watches) if watch.starved),
        )

    def _probe(self, watch: _Watch) -> Tally:
        probed = Tally()
        if self.place.first:
            with watch.catch_errors():
                probed = watch.measure.probe(self.entry.scheme, self.view, self.settings)
                claims = (c for c in self.entry.scheme.promises if c.measure == watch.measure.name)
                if any(c.when <= self.view.traits and rests_on_moments(c, watch.measure) for c in claims):
                    probed = probed.merge(packed(NAME, explosion(self.entry.scheme, self.view)))
                if watch.measure.resolved_by_steps:
                    probed = probed.merge(compared_steps(self.entry.scheme, self.view, self.followed))
        return probed

    @contextmanager
    def _catch_errors(self) -> Iterator[None]:
        """Time a piece of work and keep what the scheme raises as the reason of its cells."""
        begun = time.perf_counter()
        try:
            with self.place.marker.of(self.index):
                yield
        except FAULTS as error:
            self.error, self.starved = with_traceback(error), is_out_of_memory(error)
        finally:
            self.seconds += time.perf_counter() - begun
