"""Simulate all schemes and step sizes of a problem in lockstep on the same noise, block by block.

Noise is held for a few steps, states for one: memory depends neither on the number of steps nor on that of paths.
"""

import os
import time
from collections.abc import Container, Iterator, Mapping, Sequence
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
from ..contracts.measure import Measure, Observer, Snapshot, followed_by, rests_on_moments
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.specs import ProblemSpec, built
from ..contracts.stages import SCREENING
from ..contracts.tally import Tally, packed
from ..errors import FAULTS, SchemeError, is_out_of_memory, with_traceback
from ..forms import Problem
from ..noise.brownian import Brownian, LevelNoise, Source
from ..probe.explosion import NAME, explosion
from .reference import Reference
from .tracks import SchemeTracks

# Bytes: just below the largest block that, when freed, makes glibc keep smaller blocks.
LARGE_BLOCK = 2**25 - 2**16

# Index in place of a scheme's: code of the problem itself, including its exact solution.
PROBLEM = -1
# Index in place of a measure's: code of the scheme and not of a measure.
NO_MEASURE = -1


@contextmanager
def alone() -> Iterator[None]:
    """Exit in a copy of this process that the code inside made by ``fork``: only the original returns."""
    process = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != process:
            os._exit(1)


class Marker:
    """Record whose code runs, to attribute a hang or crash; this base class records nothing and sets no limits."""

    @contextmanager
    def of(self, scheme: int) -> Iterator[None]:  # noqa: ARG002 - not recorded here
        """Run code of a scheme, given by its index in the block, or of the problem."""
        with alone():
            yield

    @contextmanager
    def measure(self, index: int) -> Iterator[None]:  # noqa: ARG002
        """Run code of a measure, given by its index among the measures of the scheme."""
        yield


class Behaviour(NamedTuple):
    """Digests of the results of a scheme and a problem at fixed arguments."""

    scheme: str
    problem: str


@dataclass(frozen=True)
class Entry:
    """A scheme and the measures to apply to it."""

    scheme: Scheme
    measures: tuple[Measure, ...]


@dataclass(frozen=True)
class Task:
    """Complete input of the evidence on one problem; it can be pickled.

    Attributes
    ----------
    spec : ProblemSpec
    entries : tuple of Entry
    settings : Settings
    screened : bool
        Whether probes run before sampling, in a block of their own; otherwise they run with the first block of paths.
    stage : int
        Number of levels of the paths beyond those of the settings; see `Settings.stages`.
    followed : mapping of str to str, or None
        `Measure.follows` by name of the measure; None to take it from the entries.
    """

    spec: ProblemSpec
    entries: tuple[Entry, ...]
    settings: Settings
    screened: bool = False
    stage: int = 0
    followed: Mapping[str, str] | None = None

    @property
    def label(self) -> str:
        """Label of the problem."""
        return self.spec.label

    @property
    def following(self) -> Mapping[str, str]:
        """`Measure.follows` by name of the measure."""
        return self.followed or followed_by(measure for entry in self.entries for measure in entry.measures)

    def only(self, entries: Sequence[Entry]) -> "Task":
        """Return the task restricted to some entries, or to some of their measures."""
        return replace(self, entries=tuple(entries))

    @property
    def sampled(self) -> Settings:
        """Settings of the paths at this stage; probes use those of the whole run."""
        return self.settings.at(self.stage)


class SchemeEvidence(NamedTuple):
    """Evidence on one scheme.

    Attributes
    ----------
    tallies : tuple of Tally
        Results of sampling, one per measure.
    probes : tuple of Tally
        Results of probes, one per measure; only from the first block or the screening.
    health : Tally
        Failed paths, lost paths, truncated steps and steps of each level.
    seconds : float
    errors : tuple of str
        Reasons why there is no evidence, one per measure: a line followed by a traceback; empty if there is evidence.
    paths : int
    violation : str
        Violated contract, which prevents all measurements; empty if none.
    behaviour : Behaviour or None
        Behaviour of scheme and problem before and after; None if it was not requested.
    starved : frozenset of int
        Indices of the measures that ran out of memory.
    opened : tuple of (str, str)
        Files that the code of scheme, problem and measures has opened, with hashes of their contents.
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
    """Simulate one block of paths in the current process.

    Parameters
    ----------
    task : Task
    block : int
        Index of the block, or `SCREENING` for probes without paths.
    marker : Marker, optional
        Receives whose code runs.

    Returns
    -------
    tuple of SchemeEvidence
        One for each entry of the task.
    """
    try:
        _keep_freed_memory()
        # Non-finite numbers are evidence here: they are counted, and warnings are suppressed.
        with np.errstate(all="ignore"), one_thread():
            return _run_block(task, block, marker or Marker())
    except FAULTS as error:
        reason = f"problem {task.spec.label}: {with_traceback(error)}"
        starved = is_out_of_memory(error)
        return tuple(without_evidence(entry, reason, starved=starved) for entry in task.entries)


def one_thread() -> AbstractContextManager[object]:
    """Limit linear algebra to one thread: sums depend on the number of threads, and workers share the cores."""
    limited: AbstractContextManager[object] = _threads().limit(limits=1)
    return limited


@cache
def _threads() -> ThreadpoolController:
    # Only loaded libraries are limited, so SciPy's linear algebra is loaded first.
    import_module("scipy.linalg")
    return ThreadpoolController()


def _keep_freed_memory() -> None:
    """Free a large block once: glibc then keeps the freed arrays of a step, which saves time at the next step."""
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
    """Return evidence without measurements, with the reason of their absence.

    Parameters
    ----------
    entry : Entry
        The scheme and the measures that were to be applied.
    error : str
        Reason, in a line; empty if the contract was violated.
    seconds : float
        Time spent before the failure.
    violation : str
        Violated contract; empty if none.
    starved : bool
        Whether memory ran out, so that a smaller task may succeed.
    """
    nothing = tuple(Tally() for _ in entry.measures)
    errors, measures = tuple(error for _ in entry.measures), range(len(entry.measures) if starved else 0)
    return SchemeEvidence(
        nothing, nothing, Tally(), seconds, errors, violation=violation, starved=frozenset(measures)
    )


class _Place(NamedTuple):
    """Data shared by all schemes of a block."""

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

    def advance(level: int, noise: LevelNoise) -> None:
        with place.marker.of(PROBLEM):
            reference.advance(level, noise, extra)
        for run in runs:
            run.advance(level, noise)

    def note() -> None:
        for run in runs:
            run.note()

    brownian.follow(coarsest, advance, note)


class _Watch:
    """One measure on one scheme; an error in the measure affects this measure only."""

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
        """Store an error of the measure as its reason and stop observing."""
        try:
            with self.marker.measure(self.index):
                yield
        except FAULTS as error:
            if not self.error:
                self.error = f"measure {self.measure.name}: {with_traceback(error)}"
                self.starved = is_out_of_memory(error)
            self.observer = None

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Pass the components after a step of one level to the observer; ignored after an error."""
        if self.observer is not None:
            with self.catch_errors():
                self.observer.after_step(level, step, parts)

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Pass the states of all levels after a coarsest step to the observer; ignored after an error."""
        if self.observer is not None:
            with self.catch_errors():
                self.observer.after_coarsest_step(snapshot)

    def tally(self) -> Tally:
        """Return the observer's tally, or an empty one if there is no observer."""
        noted = Tally()
        if self.observer is not None:
            with self.catch_errors():
                noted = self.observer.tally()
        return noted


class _Run:
    """One scheme on one block; an error in the scheme affects this scheme only."""

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
        """Whether there is an observer and no error of the scheme."""
        return not self.error and any(watch.observer for watch in self.watches)

    def advance(self, level: int, noise: LevelNoise) -> None:
        """Make the scheme's steps on a piece of noise of a level, unless it has failed or is not sampled."""
        if self.sampled:
            with self._catch_errors():
                self.tracks.advance(level, noise, self.watches)

    def note(self) -> None:
        """Pass the states of the scheme and the exact solution at the end of a coarsest step to the observers."""
        if self.sampled:
            with self._catch_errors():
                self.tracks.find_ended(self.place.problem)
                snapshot = self.tracks.snapshot(self.reference.parts())
                for watch in self.watches:
                    watch.after_coarsest_step(snapshot)

    def evidence(self) -> SchemeEvidence:
        """Return the tallies of all measures, and their probes in the first block."""
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
        """Measure the time of a piece of work, and store an error of the scheme as the reason of its cells."""
        begun = time.perf_counter()
        try:
            with self.place.marker.of(self.index):
                yield
        except FAULTS as error:
            self.error, self.starved = with_traceback(error), is_out_of_memory(error)
        finally:
            self.seconds += time.perf_counter() - begun
