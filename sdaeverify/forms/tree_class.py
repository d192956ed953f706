"""What a form offers so that a scheme's order conditions can be asked for its equations: trees, and what has them.

A form says which derivatives of its coefficients a step of a scheme can be a sum of, as a few kinds of `Node`, and
poses a problem whose components are given trees of them. All else follows: which trees there are, what the solution
has in their place, what a step has, and the conditions on it.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ..arrays import Array

# What stands in the place of a subtree where a coefficient is derived by time.
TIME = "t"
# By how much a step on a problem below is later than that on the problem above it, whose coefficients are those of a
# later time.
LATER = 0.25
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
    """

    below: Any
    above: Any
    maps: Mapping[str, tuple[Array, Array]]
    driven: Array
    later: float = 0.0


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

    def written(self, grove: Grove) -> Written | None:  # noqa: ARG002 - most classes write nothing
        """Return the problem that has trees as components as source code, from a state of zeros; None for no code.

        Parameters
        ----------
        grove : Grove
        """
        return None
