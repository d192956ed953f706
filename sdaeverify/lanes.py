"""One scheme on one problem at all step sizes: advanced over a coarsest step at a time, watched by measures."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from .arrays import Array, Mask, Parts
from .forms import Problem
from .noise import LevelNoise, Piece
from .numerics import all_finite
from .scheme import Scheme, State, Step, flatten, same_kind
from .tally import Tally

# A finite state this much larger than the initial one is a moment explosion on its way to overflow.
BLOW_UP = 1e8


class Moments(NamedTuple):
    """What is known at the end of a coarsest step.

    Attributes
    ----------
    levels : sequence of mapping
        Named components of the scheme's state at each level, coarsest first.
    truth : mapping
        The same of the truth.
    coarser_truth : mapping or None
        The same of the truth at half its resolution, where it has an error of its own.
    """

    levels: Sequence[Parts]
    truth: Parts
    coarser_truth: Parts | None


class Observer(Protocol):
    """A measure's notebook for one scheme on one block of paths."""

    wanted: Sequence[frozenset[int]]
    """Steps of each level after which `after_step` is called."""

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Note the named components after a wanted step."""

    def after_coarsest_step(self, moments: Moments) -> None:
        """Note the named components of all levels and of the truth."""

    def tally(self) -> Tally:
        """Return what was noted."""


def parts_of(state: State, problem: Any) -> Parts:
    """Return the named components of a scheme's state."""
    if not isinstance(state, tuple):
        named: Parts = problem.parts(state)
        return named
    fields: Mapping[str, Array] = state._asdict()  # type: ignore[attr-defined]
    return fields


class Track:
    """A scheme at one step size on one block: its state, and the paths that went wrong."""

    def __init__(self, scheme: Scheme, problem: Problem, level: int, steps: int, paths: int) -> None:
        self.problem, self.level = problem, level
        self.h = problem.horizon / steps
        self.stepper = scheme.prepare(problem, self.h)
        self.state = scheme.start(problem, paths)
        self.limit = BLOW_UP * (1.0 + float(np.abs(flatten(self.state)).max()))
        self.failed: Mask = np.zeros(paths, dtype=bool)
        self.lost: Mask = np.zeros(paths, dtype=bool)  # not finite, or blown up
        self.truncated_steps = 0
        self.step = 0

    def advance(self, noise: LevelNoise, observers: Sequence[Observer]) -> None:
        """Make successive steps."""
        for index in range(len(noise.dW)):
            result = self._one(noise, index)
            self.state = result.state
            self.step += 1
            if result.failed is not None:
                self.failed |= result.failed
            if result.truncated is not None:
                self.truncated_steps += int(np.count_nonzero(result.truncated))
            for observer in observers:
                if self.step in observer.wanted[self.level]:
                    observer.after_step(self.level, self.step, self.parts())
        self.lost |= self._lost()

    def parts(self) -> Parts:
        """Return the named components of the state."""
        return parts_of(self.state, self.problem)

    def _lost(self) -> Mask:
        memory = flatten(self.state)
        return np.asarray(~(all_finite(memory) & (np.abs(memory).max(axis=0) <= self.limit)))

    def _one(self, noise: LevelNoise, index: int) -> Step:
        if self.step:
            return self.stepper(self.state, self.step * self.h, noise.increment(index))
        _freeze(self.state)
        result = self.stepper(self.state, 0.0, noise.increment(index))
        same_kind(self.state, result.state)
        return result


class Lane:
    """A scheme on one block of paths: one track a level, and one more where it has to be its own reference."""

    def __init__(
        self, scheme: Scheme, problem: Problem, steps: Sequence[int], paths: int, own_reference: int | None
    ) -> None:
        every = [*steps] if own_reference is None else [*steps, own_reference]
        self.tracks = [Track(scheme, problem, level, n, paths) for level, n in enumerate(every)]
        # A level of noise is told by how often the coarsest step is halved.
        self.by_level = {(n // steps[0]).bit_length() - 1: track for n, track in zip(every, self.tracks, strict=True)}
        self.levels, self.paths = len(steps), paths

    def advance(self, piece: Piece, observers: Sequence[Observer]) -> None:
        """Make the steps of a piece of noise, if there is a track at its level."""
        track = self.by_level.get(piece.level)
        if track is not None:
            track.advance(piece.noise, observers if track.level < self.levels else ())

    def parts(self) -> tuple[list[Parts], Parts | None]:
        """Return the components at every level and of the lane's own reference."""
        every = [track.parts() for track in self.tracks]
        return every[: self.levels], every[self.levels] if len(every) > self.levels else None

    def health(self) -> Tally:
        """Return failed and lost paths, truncated steps and steps of each level; a lost reference fails them all."""
        tracks, own = self.tracks[: self.levels], self.tracks[self.levels :]
        counts = {
            "failed": [
                np.count_nonzero(np.any([x.failed | x.lost for x in (track, *own)], axis=0)) for track in tracks
            ],
            "lost": [np.count_nonzero(track.lost) for track in tracks],
            "truncated": [track.truncated_steps for track in tracks],
            "steps": [track.step * self.paths for track in tracks],
        }
        return Tally(sums={name: np.array(values, dtype=float) for name, values in counts.items()})


def _freeze(state: State) -> None:
    # A step must not write into its arguments; numpy then says so itself.
    for array in state if isinstance(state, tuple) else (state,):
        array.flags.writeable = False
