"""Interface by which a form provides order conditions for its equations: trees, and problems that realise them.

A form specifies the derivatives of its coefficients of which a scheme's step is a sum, as a few kinds of `Node`, and
constructs a problem whose components are given trees of them. The rest follows: the trees, their values for the
solution and for a step, and the order conditions.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ...arrays import Array

# Symbol of a leaf in place of a subtree, for a derivative of a coefficient by time.
TIME = "t"
# Origin of a tree's value: an integral over time, one over a Brownian motion, or the product of its subtrees itself.
OVER_TIME, OVER_NOISE, PRODUCT = "dt", "dW", ""


class Node(NamedTuple):
    """A kind of nodes of trees: derivatives of one coefficient of the equation.

    For the solution, the value of a tree with the subtrees tau_1, ..., tau_k is the integral of their product over
    time or over one of the motions, or the product itself if the node is algebraic. Its weight is 2, 1 or 0: twice
    the order in h.

    Attributes
    ----------
    name : str
        Symbol of the node; those over noise are numbered.
    of : str
        The component to which a tree with this root belongs.
    takes : frozenset of str
        Components whose trees can be its subtrees, and ``t`` if the coefficient depends on time.
    integral : str
        ``dt``, ``dW`` or empty.
    least, most : int or None
        Range of the number of subtrees: most is 1 if the coefficient is linear, and 0 if it is constant. An algebraic
        node without subtrees is a number in the initial state.
    scaled : bool
        Whether the coefficient is a component times a number that is chosen with the equation. The powers of this
        number are separated, and each weighs 2 because it comes with a power of h.
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
        Index of its Brownian motion, from 0 on; -1 if it has none.
    kids : tuple of int
        Indices of its subtrees, all smaller than its own; -1 denotes a leaf t.
    """

    node: Node
    motion: int
    kids: tuple[int, ...]

    def product(self, components: Sequence[str]) -> str:
        """Return the product of its subtrees as source code, given the component of each tree."""
        return " * ".join("t" if kid < 0 else components[kid] for kid in self.kids) or "1.0"


class Grove(NamedTuple):
    """A set of trees for which a problem is requested.

    Attributes
    ----------
    trees : tuple of Grown
        With all their subtrees, without scaled nodes.
    motions : int
        Number of Brownian motions.
    number : float
        Factor of scaled nodes.
    time : float
        Start of the step; a leaf t denotes t minus this time.
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
        For each tree its component, and its row there. From any state consistent with the problem's start,
        its change in a step is the weight of the tree.
    sizes : sequence of float
        Factors of the weights.
    driven : ndarray, shape (l, M)
        Maps M Brownian motions to the problem's l ones.
    """

    problem: Any
    rows: Sequence[tuple[str, int]]
    sizes: Sequence[float]
    driven: Array


class Written(NamedTuple):
    """A problem whose components are trees, as source code.

    Attributes
    ----------
    form : str
        Name of its class.
    functions : str
        Definitions of its coefficients.
    arguments : mapping of str to object
        Arguments of the class, as source code, except noise, traits, truths, horizon and source.
    components : tuple of str
        The component of each tree, such as ``x[0]``.
    beside : tuple of str
        Descriptions of further components, one line each.
    traits : frozenset of str
        Traits that it declares.
    exact : bool
        Whether means of products of trees are powers of time.
    module : str
        Module from which the class is imported.
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
    """Two problems related by affine maps of their components: A Phi_above(t, x) + c = Phi_below(t + s, A x + c).

    Attributes
    ----------
    below, above : Problem
        Of the class; the one below has fewer components, so that no map has an inverse.
    maps : mapping of str to (ndarray, ndarray)
        For each component A and c, shapes (n, m) and (n, 1).
    driven : ndarray, shape (l, m)
        Maps the Brownian motions of the problem above to those of the one below.
    later : float
        s, which detects steps that evaluate coefficients at a wrong time; 0 if they do not depend on time.
    states : ndarray, shape (m, S), or None
        States of the problem above from which steps are made; its start if None.
    delay : float
        Delay of the problem above: its step begins later by this amount. `later` is measured from the same time.
    """

    below: Any
    above: Any
    maps: Mapping[str, tuple[Array, Array]]
    driven: Array
    later: float = 0.0
    states: Array | None = None
    delay: float = 0.0


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
        Range of the number of scaled nodes, times the step size.
    """

    name: str
    nodes: tuple[Node, ...]
    motions: int | None = None
    numbers: tuple[float, float] = (0.05, 1.0)

    @abstractmethod
    def pose(self, grove: Grove) -> Posed:
        """Return a problem of the class whose components are the given trees."""

    @abstractmethod
    def relatives(self, motions: int) -> Relatives:
        """Return two random problems of the class that an affine map relates.

        Parameters
        ----------
        motions : int
            Number of Brownian motions of the one below, if it can be chosen.
        """

    def distant(self, motions: int) -> Sequence[Relatives]:  # noqa: ARG002 - a class may have none
        """Return related problems of which the one above has size `FAR`, at random times.

        The module `far_problems` has this size, and draws states and times.

        A step that clips coefficients or states at some number, or that is different at some times, commutes with
        maps between states of size 1 at one time below 1. Empty if a class has no such problems: its verdicts then
        hold for coefficients and times of size 1.

        Parameters
        ----------
        motions : int
            As for `relatives`.
        """
        return ()

    def written(self, grove: Grove) -> Written | None:  # noqa: ARG002 - most classes write nothing
        """Return source code of the problem whose components are trees, started from zeros; None if there is none.

        Parameters
        ----------
        grove : Grove
        """
        return None
