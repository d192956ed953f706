"""What a form offers so that a scheme's order conditions can be asked for its equations: trees, and what has them.

A form says which derivatives of its coefficients a step of a scheme can be a sum of, as a few kinds of `Node`, and
poses a problem whose components are given trees of them. All else follows: which trees there are, what the solution
has in their place, what a step has, and the conditions on it.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array

# What stands in the place of a subtree where a coefficient is derived by time.
TIME = "t"
# By how much a step on a problem below is later than that on the problem above it, whose coefficients are those of a
# later time.
LATER = 0.25
# The size of a problem far out, a power of two so that scaling rounds nothing; by how much later the problem below it
# begins; and the number of Brownian motions among which those of a class are placed.
FAR, LATE, PLACES = 2.0**20, 2.0**10, 5
# What a tree's value follows from: an integral over time, one over a Brownian motion, or the product below it itself.
OVER_TIME, OVER_NOISE, PRODUCT = "dt", "dW", ""


class Node(NamedTuple):
    """A kind of nodes of trees: derivatives of one coefficient of the equation.

    A tree with the subtrees tau_1, ..., tau_k has, of the solution, the integral of their product over time or over
    one of the motions, or the product itself where the node is algebraic. It weighs 2, 1 or 0: twice the order in h.

    Attributes
    ----------
    name : str
        How it is written; those over noise are numbered.
    of : str
        The component that a tree with this root is a part of.
    takes : frozenset of str
        Components whose trees can stand below it, and ``t`` if the coefficient depends on time.
    integral : str
        ``dt``, ``dW`` or nothing.
    least, most : int or None
        How many subtrees it has: most is 1 where the coefficient is linear, and 0 where it is constant. An algebraic
        node without subtrees is a number that the state begins with.
    scaled : bool
        Whether the coefficient is a number, chosen with the equation, times a component: its powers are told apart,
        and each weighs 2 as it comes with a power of h.
    """

    name: str
    of: str
    takes: frozenset[str] = frozenset()
    integral: str = OVER_TIME
    least: int = 0
    most: int | None = None
    scaled: bool = False


class Grown(NamedTuple):
    """A tree among others.

    Attributes
    ----------
    node : Node
        The root.
    motion : int
        Which Brownian motion it is about, from 0 on; -1 if none.
    kids : tuple of int
        Places of its subtrees among the trees, each before it; -1 is a leaf t.
    """

    node: Node
    motion: int
    kids: tuple[int, ...]

    def product(self, components: Sequence[str]) -> str:
        """Return the product of its subtrees as source code, given the component of each tree."""
        return " * ".join("t" if kid < 0 else components[kid] for kid in self.kids) or "1.0"


class Grove(NamedTuple):
    """Trees that a problem is wanted for.

    Attributes
    ----------
    trees : tuple of Grown
        With all their subtrees, without scaled nodes.
    motions : int
        Number of Brownian motions.
    number : float
        What scaled nodes are multiplied with.
    time : float
        When the step begins: t minus this stands in the place of a leaf t.
    """

    trees: tuple[Grown, ...]
    motions: int
    number: float
    time: float


class Posed(NamedTuple):
    """A problem whose components are trees.

    Attributes
    ----------
    problem : Problem
        With all noise drawn, and a horizon of 1.
    rows : sequence of (str, int)
        For each tree its component, and its row there. From any state that the problem's start is consistent with,
        its change in a step is the weight of the tree.
    sizes : sequence of float
        What the weights are multiplied with.
    driven : ndarray, shape (l, M)
        The problem's l Brownian motions out of M.
    """

    problem: Any
    rows: Sequence[tuple[str, int]]
    sizes: Sequence[float]
    driven: Array


class Written(NamedTuple):
    """A problem whose components are trees, as source code of its own.

    Attributes
    ----------
    form : str
        Name of its class.
    functions : str
        Definitions of its coefficients.
    arguments : mapping of str to object
        What the class is called with, as source code, but for noise, traits, truths, horizon and source.
    components : tuple of str
        Of each tree, such as ``x[0]``.
    beside : tuple of str
        What else the problem has, a line each.
    traits : frozenset of str
        That it declares.
    exact : bool
        Whether means of products of trees are powers of time.
    module : str
        From which the class is imported.
    """

    form: str
    functions: str
    arguments: Mapping[str, object]
    components: tuple[str, ...]
    beside: tuple[str, ...] = ()
    traits: frozenset[str] = frozenset()
    exact: bool = True
    module: str = "sdaeverify"


class Relatives(NamedTuple):
    """Two problems that affine maps of their components relate: A Phi_above(t, x) + c = Phi_below(t + s, A x + c).

    Attributes
    ----------
    below, above : Problem
        Of the class, the one below with fewer components, so that no map has an inverse.
    maps : mapping of str to (ndarray, ndarray)
        For each component A and c, shapes (n, m) and (n, 1).
    driven : ndarray, shape (l, m)
        The Brownian motions of the problem below out of those of the one above.
    later : float
        s, which tells a step that takes coefficients at another time; 0 where they do not depend on time.
    states : ndarray, shape (m, S), or None
        States of the problem above from which steps are made; its start alone if None.
    """

    below: Any
    above: Any
    maps: Mapping[str, tuple[Array, Array]]
    driven: Array
    later: float = 0.0
    states: Array | None = None


def far_states(rng: np.random.Generator, m: int) -> Array:
    """Return states of a problem of the size `FAR`, shape (m, 64).

    A fourth of them have the size `FAR`/8. Of the others each component has a random sign and a random size between 1
    and that, so that a step that is another one in some region meets states inside and outside of it.

    Parameters
    ----------
    rng : numpy.random.Generator
    m : int
        Number of components.
    """
    near = FAR / 8.0 * rng.standard_normal((m, 16))
    sizes = np.exp2(rng.uniform(0.0, np.log2(FAR / 8.0), (m, 48)))
    return np.concatenate([near, rng.choice([-1.0, 1.0], sizes.shape) * sizes], axis=1)


def placements(motions: int) -> list[Array]:
    """Return ways to place some motions among `PLACES` in their order, as matrices of shape (motions, PLACES).

    Each of the `PLACES` motions, and each pair of them where there are pairs, is met by one of these.
    """
    size = min(motions, 2)
    ways, left, found = [*combinations(range(PLACES), motions)], {*combinations(range(PLACES), size)}, []
    while left:
        best = max(ways, key=lambda places: len(left.intersection(combinations(places, size))))
        left.difference_update(combinations(best, size))
        found.append(np.eye(PLACES)[list(best)])
    return found


def among(pairs: Sequence[Relatives], states: Array) -> tuple[Relatives, ...]:
    """Return pairs of problems with the states, shape (m, S), dealt out among them."""
    return tuple(pair._replace(states=states[:, k :: len(pairs)]) for k, pair in enumerate(pairs))


class TreeClass(ABC):
    """A class of equations of a form whose elementary differentials are trees.

    Attributes
    ----------
    name : str
        Of the class, for users.
    nodes : tuple of Node
        Kinds of nodes, at most one of them scaled.
    motions : int or None
        Number of Brownian motions; None for any number.
    numbers : (float, float)
        Between which values the number of scaled nodes, times the step size, can be chosen.
    """

    name: str
    nodes: tuple[Node, ...]
    motions: int | None = None
    numbers: tuple[float, float] = (0.05, 1.0)

    @abstractmethod
    def pose(self, grove: Grove) -> Posed:
        """Return a problem of the class that has trees as components."""

    @abstractmethod
    def relatives(self, motions: int) -> Relatives:
        """Return two random problems of the class that an affine map relates.

        Parameters
        ----------
        motions : int
            Number of Brownian motions of the one below, where it can be chosen.
        """

    def distant(self, motions: int) -> Sequence[Relatives]:  # noqa: ARG002 - a class may have none
        """Return related problems of which the one above is of the size `FAR` and the one below is late by `LATE`.

        A step that clips coefficients or states at some number, or stops to read them at some time, commutes with
        maps between states of size 1 at times below 1. Empty if a class offers none: its verdicts then hold for
        coefficients and times of size 1.

        Parameters
        ----------
        motions : int
            As for `relatives`.
        """
        return ()

    def written(self, grove: Grove) -> Written | None:  # noqa: ARG002 - most classes write nothing
        """Return the problem that has trees as components as source code, from a state of zeros; None for no code.

        Parameters
        ----------
        grove : Grove
        """
        return None
