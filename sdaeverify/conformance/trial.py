"""A trial of a step: states of a scheme on many paths, each with different noise, as read-only arrays."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from ..arrays import Array
from ..contracts.scheme import Scheme, State, Step, Stepper, flatten, require_step, same_kind
from ..contracts.stages import FIRST_BLOCK
from ..forms import Delayed
from ..noise.brownian import Increment
from ..numerics.statistics import EPS
from ..probe.step.nodes import SEED
from ..probe.step.one_step import OneStep
from ..probe.step.states import SIZE, WHEN, spread_states
from .batches import freeze, nudge, take_paths

# Accepted difference between batches in rounding errors: vector instructions round differently at the end of a row.
ROUNDINGS = 8.0


@dataclass(frozen=True)
class Trial:
    """A scheme's step at the probe states, each with its own noise; all inputs are read-only.

    Attributes
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    h : float
        Step size.
    x : ndarray, shape (d, P), or None
        Probe states; None if the scheme cannot be entered there, as with memory that `enter` does not set.
    paths : int
        Number P of paths.
    given : ndarray or NamedTuple of ndarray, P paths, optional
        The scheme's states, if they are not those entered at `x`.
    """

    scheme: Scheme
    view: Any
    h: float
    x: Array | None
    paths: int = SIZE
    given: State = None

    @cached_property
    def noise(self) -> Increment:
        """Noise of the step with the scheme's law; has H if the problem draws it."""
        rng = np.random.Generator(np.random.Philox(key=SEED))
        drawn = self.view.drawn(rng, self.h, self.paths)
        return self.lawful(drawn._replace(**self._past(rng)))

    def lawful(self, noise: Increment) -> Increment:
        """Return Brownian noise transformed to the scheme's law, read-only."""
        increment: Increment = freeze(self.scheme.law.increment(noise, self.h))
        return increment

    def _past(self, rng: np.random.Generator) -> dict[str, Array]:
        """Return lagged values around the first state if the problem has a delay."""
        delayed = self.view.capability(Delayed)
        return {} if delayed is None else delayed.near_past(rng, self.paths, 0.5)

    @cached_property
    def state(self) -> State:
        """The scheme's states at the start of the step."""
        if self.given is not None:
            return freeze(self.given)
        if self.x is not None:
            return freeze(OneStep(self.scheme, self.view).enter(self.x, WHEN * self.view.horizon, self.h))
        # All paths start at the same state; a first step separates them.
        start = freeze(self.scheme.start(self.view, self.paths, self.h))
        result = self.step(start, self.noise)
        same_kind(start, result)
        return freeze(result.state)

    @cached_property
    def stepper(self) -> Stepper:
        """The prepared step that all checks but one share, so that memory from call to call shows."""
        return self.scheme.prepare(self.view, self.h)

    def step(self, state: State, noise: Increment) -> Step:
        """Make one step at a fifth of the horizon, and require a `Step` as its result."""
        return require_step(self.stepper(state, WHEN * self.view.horizon, noise))

    @cached_property
    def first(self) -> Step:
        """Result of the step on all paths, made before any other call; its type is verified by the checks only."""
        return self.stepper(self.state, WHEN * self.view.horizon, self.noise)

    @property
    def rounding(self) -> Array:
        """Bound of the rounding error of each path, shape (P,): of its size, of its inputs, and of the algorithm.

        The last, largest for an algorithm that squares the condition of a matrix, is seen from arrays with another
        memory layout, for which sums are taken in another order.
        """
        before, after, same = flatten(self.state), flatten(self.first.state), np.arange(self.paths)
        nudged = self.step(nudge(self.state), nudge(self.noise))
        others = np.stack([flatten(nudged.state), flatten(self._made_of(same))])
        size = np.fmax(np.abs(before).max(axis=0), np.abs(after).max(axis=0))
        return np.asarray(ROUNDINGS * np.fmax(EPS * size, np.abs(others - after).max(axis=(0, 1))))

    @property
    def crowded(self) -> "Trial":
        """The same step on up to as many paths as a first block, no two of them alike, as in a run."""
        if self.given is not None:
            return self
        if self.x is None:
            return replace(self, paths=FIRST_BLOCK)
        reached = spread_states(self.view, OneStep(self.scheme, self.view).equation, FIRST_BLOCK)
        return replace(self, x=reached, paths=reached.shape[1]) if reached.shape[1] > self.paths else self

    def apart(self, paths: Array | slice) -> float:
        """Return the largest difference of some paths, in this order, from their step among all paths.

        It is relative to the largest state; 0 if within rounding, and infinite if the results cannot be compared.
        """
        got, expected = flatten(self._made_of(paths)), flatten(take_paths(self.first.state, paths))
        if got.shape != expected.shape:
            return inf
        gap = np.where((got == expected) | (np.isnan(got) & np.isnan(expected)), 0.0, np.abs(got - expected))
        if gap.any():
            gap = np.where(gap <= self.rounding[paths], 0.0, gap)
        if not gap.any():
            return 0.0
        largest = np.abs(expected).max(where=np.isfinite(expected), initial=EPS)
        return float(np.nan_to_num(gap.max() / largest, nan=inf))

    def _made_of(self, paths: Array | slice) -> State:
        return self.step(take_paths(self.state, paths), take_paths(self.noise, paths)).state
