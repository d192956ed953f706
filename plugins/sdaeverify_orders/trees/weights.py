"""Elementary weights of a scheme: the increment of each component of the universal SDE in one step."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from sdaeverify import SDE, Array, Scheme
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.trees import far_problems

from .grow import Tree, closed_sets
from .sdes.universal import Universal

TIME_0 = far_problems.TIME_0

# Largest number of entries of the diffusion per batch, and of components for a step that solves equations.
LARGEST, IMPLICIT = 4_000_000, 60
# Step sizes at which weights in units of h^(w/2) are compared; one ratio is odd.
H, OTHERS = 0.25, (0.0625, 0.25 / 3.0)
# Short step sizes, at which weights are compared up to rounding: 64 operations of a step err by 64 eps of the states.
SHORT, ROUNDINGS = (2.0**-14, 2.0**-20), 64.0
NOT_SEEN = ": no order can be observed"


class NoStepError(Exception):
    """A step cannot be computed for all noises; the message says why."""


@dataclass(frozen=True, eq=False)
class Weighing:
    """A scheme on the universal SDE of a class.

    Attributes
    ----------
    scheme : Scheme
    trees : sequence of Tree
        Trees, each after its subtrees.
    motions : int
    traits : frozenset of str
    solves : bool
        Whether a step solves equations as large as the problem; trees are then split into small closed sets.
    """

    scheme: Scheme
    trees: Sequence[Tree]
    motions: int
    traits: frozenset[str]
    solves: bool = False

    @cached_property
    def problems(self) -> list[tuple[Array, Array, SDE]]:
        """Indices of trees, their powers of h, and the problem whose components they are."""
        places = {each: place for place, each in enumerate(self.trees)}
        sets = closed_sets(self.trees, IMPLICIT) if self.solves else [list(self.trees)]
        return [
            (
                np.array([places[each] for each in some]),
                np.array([[0.5 * each.weight] for each in some]),
                Universal(some, self.motions, self.traits).sde,
            )
            for some in sets
        ]

    def weights(self, nodes: Nodes, h: float) -> Array:
        """Return phi(tau) h^(-w/2) at the nodes of the noise of a step of size h, shape (N, K).

        Raises
        ------
        NoStepError
            If a step is truncated or fails.
        """
        found = np.empty((len(self.trees), len(nodes.weights)))
        for places, powers, sde in self.problems:
            step = OneStep(self.scheme, sde)
            for part, some in _parts(nodes, sde):
                found[places, part] = (_after(step, some, h) - sde.initial(1)) / h**powers
        return found


def rounding_at(trees: Sequence[Tree], h: float) -> Array:
    """Return the rounding errors of weights in units of h^(w/2), shape (N, 1), for states of size 1."""
    return ROUNDINGS * np.finfo(float).eps / h ** np.array([[0.5 * each.weight] for each in trees])


def _parts(nodes: Nodes, sde: SDE) -> Iterator[tuple[slice, Nodes]]:
    """Yield nodes in batches of bounded memory."""
    size = max(1, LARGEST // (sde.dimension * (sde.noise_dim + 1)))
    for begin in range(0, len(nodes.weights), size):
        part = slice(begin, begin + size)
        yield part, nodes.select(part)


def _after(step: OneStep, nodes: Nodes, h: float) -> Array:
    x = step.equation.initial(len(nodes.weights))
    return stepped(step, x, nodes, h)


def stepped(step: OneStep, x: Array, nodes: Nodes, h: float, t: float = TIME_0) -> Array:
    """Return the states after a step of size h as arrays.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S K)
        States before the step, each repeated for all nodes.
    nodes : Nodes
    h : float
    t : float
        Time at the beginning of the step.

    Raises
    ------
    NoStepError
        If a step is truncated or fails, or is not finite.
    """
    return _finite(step.read(moved(step, x, nodes, h, t)[1]), h)


def moved(step: OneStep, x: Array, nodes: Nodes, h: float, t: float = TIME_0) -> tuple[Any, Any]:
    """Return the states of the scheme before and after a step of size h.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S K)
        States before the step, each repeated for all nodes.
    nodes : Nodes
    h : float
    t : float
        Time at the beginning of the step.

    Raises
    ------
    NoStepError
        If a step is truncated or fails.
    """
    with np.errstate(all="ignore"):
        state = step.enter(x, t, h)
        states = x.shape[1] // len(nodes.weights)
        after = step.scheme.prepare(step.view, h)(state, t, nodes.increment(h, states))
    for name, mask in (("fails", after.failed), ("is truncated", after.truncated)):
        if mask is not None and np.any(mask):
            every = "every" if np.all(mask) else "a"
            raise NoStepError(f"{every} step of size {h:g} {name}{NOT_SEEN if np.all(mask) else ''}")
    return state, after.state


def _finite(new: Array, h: float) -> Array:
    if not np.isfinite(new).all():
        raise NoStepError(f"a step of size {h:g} is not finite")
    return new
