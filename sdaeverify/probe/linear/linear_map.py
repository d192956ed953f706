"""Linear map of a step, x -> R x + r, at every noise node, where x contains all memory of a scheme."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import State, Step, Stepper, flatten
from ...noise.brownian import Increment
from ..step.nodes import SEED, Nodes
from ..step.one_step import OneStep
from ..step.states import spread_states
from .affine import at_corners, corners, defect, with_trials

# Steps of a run after which the map is checked: as many as `probe.step.times` compares in a row.
# Size: steps in a row.
ROW = 128
# Size: reached states at which a step is checked to be affine, at all nodes and step sizes of a scan.
REACHED = 16


class LinearMap(NamedTuple):
    """Linear map of a step at K noise nodes.

    Attributes
    ----------
    factors : ndarray, shape (k + 1, k + 1, K)
        [[R, r], [0, 1]], acting on (x, 1).
    defect : float
        Largest relative deviation of Phi(x) from R x + r: rounding if the step is linear in its state.
    failed : bool
        Whether the scheme found no root at some state or node.
    """

    factors: Array
    defect: float
    failed: bool


@dataclass(frozen=True)
class MemoryStep:
    """A step of size h, by default from time 0, between flat states (k, P) with all memory of the scheme.

    Attributes
    ----------
    one_step : OneStep
    h : float
    """

    one_step: OneStep
    h: float

    @cached_property
    def start(self) -> State:
        """Initial state of the scheme on one path, with all its memory."""
        return self.one_step.scheme.start(self.one_step.view, 1, self.h)

    @property
    def dimension(self) -> int:
        """Number k of rows of the state."""
        return len(flatten(self.start))

    @cached_property
    def stepper(self) -> Stepper:
        """Prepared step of size h."""
        return self.one_step.scheme.prepare(self.one_step.view, self.h)

    def state(self, x: Array) -> State:
        """Return the scheme's state with the flat state x."""
        if not isinstance(self.start, tuple):
            return x
        cuts = np.cumsum([len(part) for part in self.start])[:-1]
        return type(self.start)(*np.split(x, cuts))

    def advance(self, x: Array, noise: Increment, t: float = 0.0) -> tuple[Array, bool]:
        """Return the flat state after a step, NaN if the step is truncated, and whether a path found no root.

        Parameters
        ----------
        x : ndarray, shape (k, P)
            Flat state before the step.
        noise : Increment
            Noise of the step.
        t : float
            Start of the step.
        """
        step: Step = self.stepper(self.state(x), t, noise)
        after, failed = flatten(step.state), step.failed is not None and bool(np.any(step.failed))
        return after if step.truncated is None else np.where(step.truncated, np.nan, after), failed

    def at_nodes(self, x: Array, nodes: Nodes, t: float = 0.0) -> tuple[Array, bool]:
        """Return the flat states after a step from every state at every node, and whether a path found no root.

        The states have shape (k, states, K).

        Parameters
        ----------
        x : ndarray, shape (k, states)
        nodes : Nodes
        t : float
            Start of the step.
        """
        states, after, failed = x.shape[1], [], False
        for part in nodes.in_batches(states):
            values, lost = self.advance(np.repeat(x, len(part.weights), axis=1), part.increment(self.h, states), t)
            after.append(values.reshape(len(x), states, -1))
            failed = failed or lost
        return np.concatenate(after, axis=-1) if len(after) > 1 else after[0], failed

    def reached(self) -> Array:
        """Return flat states that solutions reach, shape (k, S); S = 0 if `enter` does not set all memory."""
        one_step = self.one_step
        if one_step.why_not_comparable() or one_step.why_not_entered(run=False):
            return np.zeros((self.dimension, 0))
        entered = one_step.enter(spread_states(one_step.view, one_step.equation, REACHED), 0.0, self.h)
        if one_step.memory_vanishes:
            return flatten(entered)
        later = flatten(self._run(entered))
        return np.concatenate([flatten(entered), later[:, np.isfinite(later).all(axis=0)]], axis=1)

    @property
    def remembers(self) -> bool:
        """Whether the scheme's state has more rows than the equation's."""
        return self.dimension > self.one_step.equation.dimension

    def _run(self, state: State) -> State:
        """Return the states after `ROW` steps of a run, because memory that counts steps may change the map."""
        rng, paths = np.random.Generator(np.random.Philox(key=SEED + 18)), flatten(state).shape[1]
        for n in range(ROW):
            drawn = self.one_step.view.drawn(rng, self.h, paths)
            state = self.stepper(state, n * self.h, self.one_step.scheme.law.increment(drawn, self.h)).state
        return state

    def reading(self) -> Array:
        """Return the map of (x, 1) to (y, 1), shape (d + 1, k + 1), where y are the comparable components."""
        y = self.one_step.read(self.state(corners(self.dimension)))
        return at_corners(y[..., None])[..., 0]


def linear_map(step: MemoryStep, nodes: Nodes) -> LinearMap:
    """Return the linear map of a step at every node, and the deviation of the step from it.

    Parameters
    ----------
    step : MemoryStep
    nodes : Nodes

    Returns
    -------
    LinearMap
    """
    x = with_trials(step.reached())
    values, failed = step.at_nodes(x, nodes)
    factors = at_corners(values[:, : step.dimension + 1])
    found, one_step = defect(x, values, factors), step.one_step
    if not one_step.why_not_comparable() and step.remembers:
        # The effect of memory may depend on time even if a first step from a state does not.
        late, lost = step.at_nodes(x, nodes, one_step.view.horizon - step.h)
        found, failed = max(found, defect(x, late, factors)), failed or lost
    return LinearMap(factors, found, failed)


def factors_at(step: MemoryStep, nodes: Nodes) -> Array:
    """Return [[R, r], [0, 1]] at every node, shape (k + 1, k + 1, K), without checking that the step is linear."""
    return at_corners(step.at_nodes(corners(step.dimension), nodes)[0])
