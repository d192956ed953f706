"""One scheme on one problem at all step sizes, advanced by one coarsest step at a time and observed by measures."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, Mask, Parts, each
from ..contracts.measure import Observer, Snapshot
from ..contracts.scheme import Scheme, State, Step, flatten, same_kind
from ..contracts.settings import Settings
from ..contracts.tally import Tally
from ..errors import SchemeError
from ..forms import Problem
from ..noise.brownian import Increment, LevelNoise
from ..numerics.linalg import all_finite
from ..probe.local.orders import TOLERANCE

# A finite state larger than the initial one by this factor is a moment explosion on its way to overflow.
BLOW_UP = 1e8
COST, COUNTED = "cost ", "counted "
# Name, among the arguments of constraints, of the mask of paths on which a step found no root: 1 there, else 0.
HELD = "held"


class Track:
    """A scheme at one step size on one block: its state, its failed and lost paths, and its costs."""

    def __init__(self, scheme: Scheme, problem: Problem, level: int, h: float, paths: int) -> None:
        self.scheme, self.problem, self.level, self.h = scheme, problem, level, h
        self.stepper = scheme.prepare(problem, h)
        self.state = scheme.start(problem, paths, h)
        self.recall = problem.recall(h, paths)
        self.size = 1.0 + float(np.abs(flatten(self.state)).max())
        self.failed: Mask = np.zeros(paths, dtype=bool)
        self.lost: Mask = np.zeros(paths, dtype=bool)  # not finite, or blown up
        # Number of failed paths on which the problem itself lost its root, and the sum of the times of these losses.
        self.singular, self.singular_time = 0, 0.0
        self.truncated_steps = 0
        self.costs: dict[str, float] = {}
        self.counted: dict[str, int] = {}
        self.step = 0
        # State, noise and result of the first step.
        self.first: tuple[State, Increment, Array] | None = None

    def advance(self, noise: LevelNoise, observers: Sequence[Observer]) -> None:
        """Make a step for each increment; pass the state to each observer after the steps that it requests."""
        for index in range(len(noise.dW)):
            increment, before = self._increment(noise, index), self.state
            result = self._step_once(increment)
            self._count(before, increment, result)
            self.state = result.state
            self.step += 1
            if self.recall is not None:
                self.recall.push(self.parts()["x"])
            for observer in observers:
                if self.step in observer.wanted[self.level]:
                    observer.after_step(self.level, self.step, self.constraint_arguments())

    def parts(self) -> Parts:
        """Return the named components of the current state."""
        return self.scheme.parts(self.problem, self.state)

    def constraint_arguments(self) -> Parts:
        """Return the named components together with the time and lagged values, if constraints depend on these.

        A path on which a step found no root, and which was held, cannot satisfy a constraint that depends on them
        later.
        """
        parts = self.parts()
        if not self.problem.moving_constraints:
            return parts
        lagged = parts["x"] if self.recall is None else self.recall.lagged()
        held = self.failed[None].astype(float)
        return {**parts, "t": np.full((1, 1), self.step * self.h), "lagged": lagged, HELD: held}

    def find_lost(self, size: float) -> None:
        """Mark the paths that are not finite or have blown up relative to the size of the solution."""
        memory = flatten(self.state)
        limit = BLOW_UP * max(self.size, size)
        self.lost |= ~(all_finite(memory) & (np.abs(memory).max(axis=0) <= limit))

    def find_ended(self, problem: Problem) -> None:
        """Mark the paths on which a constraint eliminated from the scheme's equation has lost its root."""
        if not self.step:
            return
        t, x = self.step * self.h, self.parts()["x"]
        ended = ~self.failed & problem.without_index(t, x, x if self.recall is None else self.recall.lagged())
        self.failed = self.failed | ended
        self.singular += int(np.count_nonzero(ended))
        self.singular_time += float(np.count_nonzero(ended) * t)

    def _count(self, before: State, noise: Increment, result: Step) -> None:
        if result.failed is not None and result.failed.any() and (new := result.failed & ~self.failed).any():
            self.failed = self.failed | new
            self._look_for_a_root(before, noise, new)
        if result.truncated is not None:
            self.truncated_steps += int(np.count_nonzero(result.truncated))
        for name, value in result.costs.items():
            counts = np.asarray(value).dtype.kind in "iu"
            self.costs[name] = self.costs.get(name, 0.0) + float(np.sum(value) if counts else np.nansum(value))
            told = np.size(value) if counts else int(np.count_nonzero(~np.isnan(value)))
            self.counted[name] = self.counted.get(name, 0) + told

    def _look_for_a_root(self, before: State, noise: Increment, paths: Mask) -> None:
        t = self.step * self.h
        lost = paths & self.problem.index_lost(t, self.h, self.scheme.parts(self.problem, before), noise)
        self.singular += int(np.count_nonzero(lost))
        self.singular_time += float(np.count_nonzero(lost) * (t + self.h))

    def _increment(self, noise: LevelNoise, index: int) -> Increment:
        increment = self.scheme.law.increment(noise.increment(index), self.h)
        return increment if self.recall is None else self.recall.add_past(increment)

    def _step_once(self, increment: Increment) -> Step:
        if self.step:
            return self.stepper(self.state, self.step * self.h, increment)
        return self._first_step(increment)

    def _first_step(self, increment: Increment) -> Step:
        _freeze(self.state)
        result = self.stepper(self.state, 0.0, increment)
        same_kind(self.state, result)
        self.first = self.state, each(np.array, increment), np.array(flatten(result.state))
        return result

    def repeat_first_step(self) -> None:
        """Repeat the first step after all others, on all paths and on every second one.

        This detects hidden state, and paths that influence each other in batches of the size of a block.

        Raises
        ------
        SchemeError
            If the result differs, on every second path by more than a solver's tolerance.
        """
        if self.first is None:
            return
        state, increment, led = self.first
        again = flatten(self.stepper(state, 0.0, increment).state)
        if not np.array_equal(led, again, equal_nan=True):
            raise SchemeError("the same step gave another result when it was repeated: it depends on hidden state")
        half, known = (each(lambda part: part[..., ::2], batch) for batch in (state, increment)), led[:, ::2]
        begin, noise = half
        apart = np.nan_to_num(np.abs(flatten(self.stepper(begin, 0.0, noise).state) - known))
        if apart.max(initial=0.0) > TOLERANCE * np.nan_to_num(np.abs(known)).max(initial=0.0):
            raise SchemeError("a step of half of the paths gives another result: paths must not affect each other")


class SchemeTracks:
    """A scheme on one block of paths: one track per level, and one more if it needs its own reference run."""

    def __init__(self, scheme: Scheme, problem: Problem, settings: Settings, paths: int, own: int | None) -> None:
        self.levels, self.paths = settings.levels, paths
        levels = [*range(settings.levels)] if own is None else [*range(settings.levels), own]
        h = problem.horizon / settings.coarsest
        self.tracks = {level: Track(scheme, problem, level, h / 2**level, paths) for level in levels}
        self.own = own

    def advance(self, level: int, noise: LevelNoise, observers: Sequence[Observer]) -> None:
        """Make the steps of a piece of noise, if there is a track at its level.

        Parameters
        ----------
        level : int
        noise : LevelNoise
            Successive steps of this level.
        observers : sequence of Observer
            Not called for the scheme's own reference run.
        """
        if level in self.tracks:
            self.tracks[level].advance(noise, () if level == self.own else observers)

    def repeat_first_steps(self) -> None:
        """Repeat the first step of each track: a step that counts its calls gives another result."""
        for track in self.tracks.values():
            track.repeat_first_step()

    def find_ended(self, problem: Problem) -> None:
        """Mark the paths on which the solution has ended, if y was eliminated from the scheme's equation."""
        track = self.tracks[0]
        if "algebraic" in problem.traits and not track.problem.has_constraints and "x" in track.parts():
            for each in self.tracks.values():
                each.find_ended(problem)

    def snapshot(self, truths: Sequence[Parts]) -> Snapshot:
        """Return the states of the scheme and the exact solution, and mark the lost paths.

        Parameters
        ----------
        truths : sequence of mapping
            Exact solution at full and, if it is inexact, at half resolution. Empty if the scheme has its own
            reference run, or if no measure needs the exact solution.
        """
        levels = [self.tracks[level].parts() for level in range(self.levels)]
        known = (truths or levels[-1:]) if self.own is None else [self.tracks[self.own].parts()]
        size = max(float(np.fmax.reduce(np.abs(part), axis=None)) for part in known[0].values())
        for track in self.tracks.values():
            track.find_lost(size)
        return Snapshot(levels, known[0], known[1] if len(known) > 1 else None)

    def health(self) -> Tally:
        """Return failures and costs of the steps at each level; a lost reference run is a failure of every level.

        Paths ``without_root`` had a step without root at the level itself. On the ``singular`` ones among them the
        problem lost its root; ``singular_time`` is the sum of the times of these losses.
        """
        tracks = [self.tracks[level] for level in range(self.levels)]
        own = [] if self.own is None else [self.tracks[self.own]]
        counts = {
            "failed": [
                np.count_nonzero(np.any([x.failed | x.lost for x in (track, *own)], axis=0)) for track in tracks
            ],
            "lost": [np.count_nonzero(track.lost) for track in tracks],
            "without_root": [np.count_nonzero(track.failed) for track in tracks],
            "singular": [track.singular for track in tracks],
            "singular_time": [track.singular_time for track in tracks],
            "truncated": [track.truncated_steps for track in tracks],
            "steps": [track.step * self.paths for track in tracks],
            **{f"{COST}{name}": [track.costs.get(name, 0.0) for track in tracks] for name in tracks[0].costs},
            **{f"{COUNTED}{name}": [track.counted.get(name, 0) for track in tracks] for name in tracks[0].costs},
        }
        return Tally(sums={name: np.array(values, dtype=float) for name, values in counts.items()})


def _freeze(state: State) -> None:
    # A step must not write into its arguments; NumPy raises an error if it does.
    for array in state if isinstance(state, tuple) else (state,):
        array.flags.writeable = False
