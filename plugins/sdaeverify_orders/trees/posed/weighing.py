"""Weights of the trees that a form defines: increments of components in a step, for several scaling values."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from sdaeverify import Array, Scheme
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.trees import Grove, Posed, TreeClass, far_problems

from ..grow import Tree, closed_sets
from ..relatives import driven
from ..weights import IMPLICIT, LARGEST, NoStepError, moved
from .grammar import grove_of

TIME_0 = far_problems.TIME_0

# Number of scaling values for the power series of weights: Chebyshev interpolation is accurate to 1e-9 at 0 up to the
# power 3, for functions such as (e^z - 1 - z)/z^2 that lose digits near 0 or have a singularity at a distance of 3.
VALUES = 11
# The interpolation error is the node polynomial times a factor that varies slowly: for weights with poles as near as
# 1, those of implicit friction, the factor is 1.8 times larger at 0 than next to a node.
SLOWLY = 2.0


@dataclass(frozen=True, eq=False)
class PosedWeighing:
    """A scheme on the problems of a class whose components are trees.

    Attributes
    ----------
    scheme : Scheme
    kind : TreeClass
    motions : int
    trees : sequence of Tree
        Closed set of trees without scaled nodes.
    made : dict
        Cache of problems by their last tree and their scaling value, for other noise.
    """

    scheme: Scheme
    kind: TreeClass
    motions: int
    trees: Sequence[Tree]
    made: dict[tuple[Tree, float], Posed] = field(default_factory=dict)

    @property
    def sets(self) -> list[list[Tree]]:
        """Small closed sets of trees, because steps may solve equations as large as the problem."""
        return closed_sets(self.trees, IMPLICIT)

    @property
    def values(self) -> Array:
        """Scaling values times the step size; 1 alone if a class has no scaled nodes."""
        if not any(node.scaled for node in self.kind.nodes):
            return np.ones(1)
        low, high = self.kind.numbers
        angles = np.pi * (np.arange(VALUES) + 0.5) / VALUES
        return np.asarray(0.5 * (low + high) - 0.5 * (high - low) * np.cos(angles))

    @property
    def few(self) -> slice:
        """Slice of a few values including the first and the last, enough to test whether weights depend on h."""
        return slice(None, None, max(1, len(self.values) // 2))

    def powers(self, count: int) -> Array:
        """Return the matrix from function values to the coefficients of the first `count` powers."""
        if len(self.values) == 1:
            return np.ones((1, 1))
        return self._at_0(np.linalg.inv(self._polynomials(self.values)), count)

    def growth(self, count: int) -> Array:
        """Return the ratio of the interpolation error in the coefficients of powers to that between values.

        The values are the roots of a Chebyshev polynomial T, and the error at z is T(z) times a factor that varies
        slowly. Outside the interval of the values T grows fast, and its derivatives faster.
        """
        if len(self.values) == 1:
            return np.zeros(1)
        T = np.eye(VALUES + 1)[-1]
        between = np.polynomial.chebyshev.chebval(self._scaled(np.array([self._between]))[0], T)
        return np.asarray(SLOWLY * np.abs(self._at_0(T, count) / between))

    def _at_0(self, series: Array, count: int) -> Array:
        """Return the first `count` coefficients of powers at 0 of Chebyshev series, which are columns."""
        low, high = self.kind.numbers
        centre, of_powers, factor = self._scaled(np.zeros(1))[0], [], 1.0
        for k in range(count):
            derivatives = np.polynomial.chebyshev.chebder(series, k) if k else series
            of_powers.append(factor * np.polynomial.chebyshev.chebval(centre, derivatives))
            factor *= 2.0 / (high - low) / (k + 1.0)
        return np.array(of_powers)

    @property
    def _between(self) -> float:
        return 0.5 * float(self.values[0] + self.values[1])

    def _polynomials(self, values: Array) -> Array:
        """Return the Chebyshev polynomials at some values, one per column."""
        return np.asarray(np.polynomial.chebyshev.chebvander(self._scaled(values), VALUES - 1))

    def _scaled(self, values: Array) -> Array:
        low, high = self.kind.numbers
        return np.asarray((2.0 * values - low - high) / (high - low))

    def interpolated(self, found: Array) -> tuple[float, Array]:
        """Return a value between two others, and the interpolation there of `found` at all values."""
        value = self._between
        at = self._polynomials(np.array([value]))[0] @ np.linalg.inv(self._polynomials(self.values))
        return value, np.tensordot(at, found, axes=1)

    def at_values(self, nodes: Nodes, h: float, values: Array) -> Array:
        """Return phi(tau) h^(-w/2) at given scaling values times h, shape (G, N, K).

        Parameters
        ----------
        nodes : Nodes
        h : float
        values : ndarray, shape (G,)
            Subset of `values`.

        Raises
        ------
        NoStepError
            If a step is truncated or fails.
        """
        found = np.empty((len(values), len(self.trees), len(nodes.weights)))
        places = {each: place for place, each in enumerate(self.trees)}
        for some in self.sets:
            powers = np.array([[0.5 * each.weight] for each in some])
            at = [places[each] for each in some]
            for g, value in enumerate(values):
                found[g, at] = changes(self.scheme, self._posed(some, float(value) / h), nodes, h) / h**powers
        return found

    def _posed(self, trees: list[Tree], number: float) -> Posed:
        key = (trees[-1], number if len(self.values) > 1 else 1.0)
        if key not in self.made:
            grove = grove_of(trees, self.kind.nodes, Grove((), self.motions, key[1], TIME_0))
            self.made[key] = self.kind.pose(grove)
        return self.made[key]


def changes(scheme: Scheme, posed: Posed, nodes: Nodes, h: float) -> Array:
    """Return the increment of each tree in a step, shape (N, K).

    Parameters
    ----------
    scheme : Scheme
    posed : Posed
        Problem whose components are the trees.
    nodes : Nodes
        Noise of a step of length 1, of the Brownian motions of the class.
    h : float

    Raises
    ------
    NoStepError
        If a step is truncated or fails, or is not finite.
    """
    step = OneStep(scheme, posed.problem)
    size = max(1, LARGEST // max(step.equation.dimension, step.equation.noise_dim + 1) ** 2)
    found = np.empty((len(posed.rows), len(nodes.weights)))
    for begin in range(0, len(nodes.weights), size):
        part = slice(begin, begin + size)
        some = driven(nodes.select(part), posed.driven)
        states = moved(step, step.equation.initial(len(some.weights)), some, h)
        before, after = (scheme.parts(posed.problem, state) for state in states)
        found[:, part] = [after[name][row] - before[name][row] for name, row in posed.rows]
    if not np.isfinite(found).all():
        raise NoStepError(f"a step of size {h:g} is not finite")
    return np.asarray(found / np.array(posed.sizes)[:, None])
