"""One block of an experiment's paths on one noise: all schemes and step sizes on the same Brownian paths."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Mask, Parts, Problem, ProblemError, Scheme, SchemeError
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.measuring import Snapshot, Tally
from sdaeverify.studying import Brownian, LevelNoise, ProblemSpec, Source, Track, match, one_thread

from .experiment import EACH, MAX, MEAN, Note, Noted, ProbeFound, RunFound, SchemeRun, SharedNoise


class Notebook:
    """Observer of one track for one note; an error affects this note only.

    Parameters
    ----------
    track : Track
    problem : Problem
        Problem as registered, whose observables are used.
    note : Note
    steps : int
        Number of steps of the run.
    """

    def __init__(self, track: Track, problem: Problem, note: Note, steps: int) -> None:
        self.track, self.problem, self.note, self.h = track, problem, note, problem.horizon / steps
        self.wanted: list[Sequence[int]] = [()] * track.level + [note.steps(steps)]
        self.at: list[int] = []
        self.values: list[Array] = []
        self.without_root: list[Mask] = []
        self.lost: list[Mask] = []
        self.error = ""

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Record the value after this step."""
        if self.error:
            return
        try:
            found = self._value(step * self.h, parts)
        except FAULTS as error:
            self.error = one_line(error)
            return
        self.track.find_lost(0.0)
        # Values on lost paths are NaN, even if the function returns a finite value.
        self._keep(step, np.where(self.track.lost, np.nan, found))

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Ignore the coarsest step, since a track has one level."""

    def tally(self) -> Tally:
        """Return an empty tally, because notes are merged by experiments."""
        return Tally()

    def conclude(self) -> Noted:
        """Return the recorded values."""
        if self.error or not self.values:
            return Noted(error=self.error or "not reached")
        values = np.stack(self.values)
        if self.note.over == MEAN:
            values = values / len(self.at)
        at = tuple(self.at) if self.note.over == EACH else (self.at[-1],)
        return Noted(values, np.stack(self.without_root), np.stack(self.lost), at)

    def _value(self, t: float, parts: Parts) -> Array:
        of, known = self.note.of, self.problem.observables
        if not isinstance(of, str):
            return of(self.problem, t, parts)
        if of not in known:
            raise ProblemError(f"the problem has no observable {of!r}; it has {', '.join(known)}")
        return known[of](t, parts)

    def _keep(self, step: int, value: Array) -> None:
        if self.values and self.note.over != EACH:
            before = self.values.pop()
            value = np.fmax(before, value) if self.note.over == MAX else before + value
            # fmax ignores NaN, but the maximum on a lost path must be NaN.
            value = np.where(self.track.lost, np.nan, value)
            self.without_root.clear()
            self.lost.clear()
        self.at.append(step)
        self.values.append(value)
        self.without_root.append(self.track.failed.copy())
        self.lost.append(self.track.lost.copy())


class PlannedRun(NamedTuple):
    """A run with its labels resolved."""

    run: SchemeRun
    spec: ProblemSpec
    scheme: Scheme


@dataclass(frozen=True)
class NoiseTask:
    """All inputs of the runs on one noise, which can be pickled.

    Attributes
    ----------
    runs : tuple of PlannedRun
    noise : SharedNoise or None
        Shared noise; None for that of the problem.
    seed : int
    block : int
        Number of paths of a full block.
    """

    runs: tuple[PlannedRun, ...]
    noise: SharedNoise | None
    seed: int
    block: int

    @property
    def label(self) -> str:
        """Name of the noise."""
        return self.noise.name if self.noise else self.runs[0].spec.label


@dataclass(frozen=True)
class ProbeTask:
    """A probe with its labels resolved."""

    of: Callable[[tuple[Problem, ...], tuple[Scheme, ...]], Mapping[str, Array]]
    specs: tuple[ProblemSpec, ...]
    schemes: tuple[Scheme, ...]
    label: str


def run_probe(task: ProbeTask) -> ProbeFound:
    """Evaluate a probe, in a worker process or in this one."""
    try:
        with np.errstate(all="ignore"), one_thread():
            found = task.of(tuple(spec.build() for spec in task.specs), task.schemes)
            return ProbeFound({name: np.asarray(values) for name, values in found.items()})
    except FAULTS as error:
        return ProbeFound(error=one_line(error))


def run_block(task: NoiseTask, block: int, paths: int) -> tuple[RunFound, ...]:
    """Simulate one block of paths, in a worker process or in this one.

    Parameters
    ----------
    task : NoiseTask
    block : int
        Index of the block.
    paths : int
        Number of its paths that are used.

    Returns
    -------
    tuple of RunFound
        Results, one for each run.
    """
    try:
        # Lost paths are counted, without warnings.
        with np.errstate(all="ignore"), one_thread():
            return _run_block(task, block, paths)
    except FAULTS as error:
        return tuple(RunFound(error=f"noise {task.label}: {one_line(error)}") for _ in task.runs)


def _run_block(task: NoiseTask, block: int, paths: int) -> tuple[RunFound, ...]:
    coarsest = min(planned.run.steps for planned in task.runs)
    tracks = [_Driven(planned, coarsest, paths) for planned in task.runs]
    horizon = _common("final time", {track.problem.horizon for track in tracks if track.problem})
    dimension = task.noise.dimension if task.noise else _common(
        "number of Brownian motions", {track.problem.noise_dim for track in tracks if track.problem}
    )  # fmt: skip
    source = Source(task.seed, task.label, block, task.block, paths)
    fields = frozenset({"dW"}).union(*(planned.scheme.noise for planned in task.runs))
    finest = max(track.level for track in tracks)
    records = next((track.problem.records for track in tracks if track.problem and not task.noise), ())
    brownian = Brownian(source, int(dimension), horizon / coarsest, finest, fields, records)

    def advance(level: int, noise: LevelNoise) -> None:
        for track in tracks:
            track.advance(level, noise)

    brownian.follow(coarsest, advance)
    return tuple(track.conclude(paths) for track in tracks)


def _common(what: str, values: set[float] | set[int]) -> float:
    if len(values) != 1:
        raise ProblemError(f"runs on the same noise need the same {what}, got {', '.join(map(str, sorted(values)))}")
    return values.pop()


class _Driven:
    """A run in progress; an error affects its results only."""

    def __init__(self, planned: PlannedRun, coarsest: int, paths: int) -> None:
        self.run, self.error = planned.run, ""
        self.level = (planned.run.steps // coarsest).bit_length() - 1
        self.books: dict[str, Notebook] = {}
        self.problem: Problem | None = None
        with self._catch_errors(f"problem {planned.spec.label}"):
            self.problem = planned.spec.build()
        self.where = f"scheme {planned.scheme.label}"
        if self.problem is not None:
            with self._catch_errors(self.where):
                self._begin(planned.scheme, self.problem, paths)

    def _begin(self, scheme: Scheme, problem: Problem, paths: int) -> None:
        matched = match(scheme, problem)
        if matched.problem is None:
            raise SchemeError(matched.reason)
        steps = self.run.steps
        self.h, self.noise_dim = problem.horizon / steps, problem.noise_dim
        self.track = Track(scheme, matched.problem, self.level, self.h, paths)
        self.books = {note.name: Notebook(self.track, problem, note, steps) for note in self.run.notes}

    def advance(self, level: int, noise: LevelNoise) -> None:
        """Make the steps of a piece of noise of this level."""
        if level == self.level and not self.error:
            with self._catch_errors(self.where):
                self.track.advance(self._driving(noise), tuple(self.books.values()))

    def _driving(self, noise: LevelNoise) -> LevelNoise:
        drive = self.run.drive
        if drive is not None:
            noise = noise._replace(dW=drive(noise.dW), H=None if noise.H is None else drive(noise.H))
        if noise.dW.shape[1] != self.noise_dim:
            raise ProblemError(f"the problem has {self.noise_dim} Brownian motions, the noise {noise.dW.shape[1]}")
        return noise

    def conclude(self, paths: int) -> RunFound:
        """Return the results, or the error."""
        if self.error:
            return RunFound(error=self.error)
        costs = {
            name: np.array([[total, self.track.counted[name]]], dtype=float)
            for name, total in self.track.costs.items()
        }
        costs["truncated"] = np.array([[self.track.truncated_steps, self.track.step * paths]], dtype=float)
        return RunFound(self.h, {name: book.conclude() for name, book in self.books.items()}, costs, paths)

    @contextmanager
    def _catch_errors(self, where: str) -> Iterator[None]:
        try:
            yield
        except FAULTS as error:
            self.error = f"{where}: {one_line(error)}"
