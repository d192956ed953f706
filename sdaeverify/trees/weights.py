"""The elementary weights of a scheme: what one step makes of each component of the universal SDE."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array
from ..contracts.scheme import Scheme
from ..forms import SDE
from ..probing import Nodes, OneStep
from .grow import Tree, closed_sets
from .sdes.universal import TIME_0, Universal

# Numbers in the diffusion at so many nodes at once, and components of a step that solves equations.
LARGEST, IMPLICIT = 4_000_000, 60
# Step sizes: weights in units of h^(w/2) are compared at these, one ratio being odd.
H, OTHERS = 0.25, (0.0625, 0.25 / 3.0)
NOT_SEEN = ": the order is never seen"


class NoStepError(Exception):
    """A step that cannot be evaluated at all noises, which its message explains."""


@dataclass(frozen=True, eq=False)
class Weighing:
    """A scheme on the universal SDE of a class.

    Attributes
    ----------
    scheme : Scheme
    trees : sequence of Tree
        Each behind its subtrees.
    motions : int
    traits : frozenset of str
    solves : bool
        Whether a step solves equations that are as large as the problem: trees are then taken in small closed sets.
    """

    scheme: Scheme
    trees: Sequence[Tree]
    motions: int
    traits: frozenset[str]
    solves: bool = False

    @cached_property
    def problems(self) -> list[tuple[Array, Array, SDE]]:
        """Places of the trees and their powers of h, with a problem whose components they are."""
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
        """Return phi(tau) h^(-w/2), shape (N, K), at the nodes of the noise of a step of size h.

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


def _parts(nodes: Nodes, sde: SDE) -> Iterator[tuple[slice, Nodes]]:
    """Yield nodes in parts of bounded memory."""
    size = max(1, LARGEST // (sde.dimension * (sde.noise_dim + 1)))
    for begin in range(0, len(nodes.weights), size):
        part = slice(begin, begin + size)
        yield part, nodes.select(part)


def _after(step: OneStep, nodes: Nodes, h: float) -> Array:
    x = step.equation.initial(len(nodes.weights))
    return stepped(step, x, nodes, h)


def stepped(step: OneStep, x: Array, nodes: Nodes, h: float, t: float = TIME_0) -> Array:
    """Return the states after a step of size h.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S K)
        The states before, each for all nodes.
    nodes : Nodes
    h : float
    t : float
        When it begins.

    Raises
    ------
    NoStepError
        If a step is truncated or fails, or is not finite.
    """
    return _finite(step.read(moved(step, x, nodes, h, t)[1]), h)


def moved(step: OneStep, x: Array, nodes: Nodes, h: float, t: float = TIME_0) -> tuple[Any, Any]:
    """Return the scheme's own states before and after such a step.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S K)
        The states before, each for all nodes.
    nodes : Nodes
    h : float
    t : float
        When the step begins.

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
