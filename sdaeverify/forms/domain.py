"""Sets that solutions do not leave: a half line, an orthant, a box, a simplex, a ball, or a user-defined set."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Mask

# Approximate size of states drawn from an unbounded set.
SIZE = 1.0
# Number of states by which inclusion of a set in another one is tested, and the seed of their draw.
STATES, SEED = 256, 20
# Rounding of a sum or norm of components.
ROUNDING = 1e-12
# Bisections of the segment to a state outside; they determine its last point inside to rounding.
BISECTIONS = 52
NONNEGATIVE = "nonnegative"


@dataclass(frozen=True, eq=False)
class Domain:
    """A set of states that the solution of a problem does not leave, or that a scheme is made for.

    States at which steps are compared with the equation are drawn from it. A scheme with a domain is only applied to
    problems whose own domain is contained in it, and to trivial equations whose solutions stay in it.

    Attributes
    ----------
    name : str
        Text that follows "states with", such as ``x >= 0``.
    contains : callable, ndarray of shape (d, P) -> ndarray of bool, shape (P,)
        Indicator of the set; rows in the order of the problem's Ito equation.
    sample : callable, (numpy.random.Generator, d, P) -> ndarray of shape (d, P)
        Draws random states in the set, away from its boundary.
    nonnegative : bool
        Whether all components are nonnegative: the problem then has the trait ``nonnegative``.
    dimension : int, optional
        Number d of components, if only one is possible.
    """

    name: str
    contains: Callable[[Array], Mask]
    sample: Callable[[np.random.Generator, int, int], Array]
    nonnegative: bool = False
    dimension: int | None = None

    def __str__(self) -> str:
        return self.name

    @classmethod
    def orthant(cls) -> "Domain":
        """Return the states whose components are all nonnegative; in one dimension the half line."""
        return cls("x >= 0", _is_nonnegative, _sample_orthant, nonnegative=True)

    @classmethod
    def box(cls, low: ArrayLike, high: ArrayLike) -> "Domain":
        """Return the states with low <= x <= high in each component.

        Parameters
        ----------
        low, high : array_like, shape (d,) or scalar
        """
        a, b = np.atleast_1d(np.asarray(low, dtype=float)), np.atleast_1d(np.asarray(high, dtype=float))

        def contains(x: Array) -> Mask:
            return np.asarray(((x >= a[:, None]) & (x <= b[:, None])).all(axis=0))

        def sample(rng: np.random.Generator, d: int, count: int) -> Array:
            return np.asarray(a[:, None] + (b - a)[:, None] * rng.uniform(0.1, 0.9, (d, count)))

        d, positive = max(len(a), len(b)), bool((a >= 0.0).all())
        name = f"{_words(a)} <= x <= {_words(b)}"
        return cls(name, contains, sample, nonnegative=positive, dimension=d if d > 1 else None)

    @classmethod
    def simplex(cls) -> "Domain":
        """Return the states whose components are nonnegative with a sum of at most 1."""

        def contains(x: Array) -> Mask:
            return np.asarray((x >= 0.0).all(axis=0) & (x.sum(axis=0) <= 1.0 + ROUNDING))

        def sample(rng: np.random.Generator, d: int, count: int) -> Array:
            return rng.dirichlet(np.full(d + 1, 2.0), count).T[:d]

        return cls("x >= 0 and a sum of at most 1", contains, sample, nonnegative=True)

    @classmethod
    def ball(cls, radius: float) -> "Domain":
        """Return the states with |x| <= radius; for solutions on a sphere use the constraint of `SDE` instead."""

        def contains(x: Array) -> Mask:
            return np.asarray((x * x).sum(axis=0) <= radius**2 * (1.0 + ROUNDING))

        def sample(rng: np.random.Generator, d: int, count: int) -> Array:
            x = rng.standard_normal((d, count))
            return np.asarray(0.9 * radius * rng.uniform(size=count) ** (1.0 / d) * x / np.sqrt((x * x).sum(axis=0)))

        return cls(f"|x| <= {radius:g}", contains, sample)

    def repeated(self, count: int) -> "Domain":
        """Return the states with `count` blocks of components in the domain, such as a solution and its past."""

        def contains(x: Array) -> Mask:
            return np.asarray(np.all([self.contains(block) for block in np.split(x, count)], axis=0))

        def sample(rng: np.random.Generator, d: int, paths: int) -> Array:
            return np.concatenate([self.sample(rng, d // count, paths) for _ in range(count)])

        return Domain(self.name, contains, sample, nonnegative=self.nonnegative)

    def draw(self, d: int, count: int, seed: int = SEED) -> Array:
        """Draw random states, shape (d, count), the same for the same seed.

        Parameters
        ----------
        d : int
            Number of components.
        count : int
            Number of states.
        seed : int, optional
            Of the random numbers.
        """
        return self.sample(np.random.Generator(np.random.Philox(key=seed)), d, count)

    def farthest(self, x: Array, y: Array) -> Array:
        """Return the last points in the domain on the segments from x to y, by bisection.

        Parameters
        ----------
        x : ndarray, shape (d, P)
            States in the domain.
        y : ndarray, shape (d, P)
            End points; returned unchanged if in the domain.
        """
        low, high = np.zeros(x.shape[1]), np.where(self.contains(y), 0.0, 1.0)
        for _ in range(BISECTIONS * bool(high.any())):
            middle = 0.5 * (low + high)
            inside = self.contains(x + middle * (y - x))
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return np.asarray(np.where(high > 0.0, x + low * (y - x), y))

    def keep(self, x: Array, before: Array) -> Array:
        """Return states x, shape (d, P), with those outside the domain replaced by the previous states."""
        return np.asarray(np.where(self.contains(x), x, before))


def outside(problem: Any, x: Array) -> Mask:
    """Return the paths on which states x, shape (d, P), are not in the domain of a problem.

    Parameters
    ----------
    problem : Problem
        Without a domain, no state is outside.
    x : ndarray, shape (d, P)
        States of its Ito equation.
    """
    domain: Domain | None = problem.domain
    return np.zeros(x.shape[1], dtype=bool) if domain is None else ~domain.contains(x)


def why_not_within(problem: Any, domain: Domain | None) -> str:
    """Return why a problem's states are not known to stay in the domain of a scheme, or an empty string.

    Parameters
    ----------
    problem : Problem
    domain : Domain or None
        Domain of the scheme; None means all states.
    """
    if domain is None:
        return ""
    if problem.domain is None:
        return f"is for states with {domain}, and the problem declares no domain"
    equation = problem.equation()
    d = 1 if equation is None else equation.dimension
    inside = problem.domain is domain or domain.contains(problem.domain.draw(d, STATES)).all()
    return "" if inside else f"is for states with {domain}; those of the problem have {problem.domain}"


def _is_nonnegative(x: Array) -> Mask:
    return np.asarray((x >= 0.0).all(axis=0))


def _sample_orthant(rng: np.random.Generator, d: int, count: int) -> Array:
    return SIZE * np.exp(rng.uniform(-1.0, 1.0, (d, count)))


def _words(bound: Array) -> str:
    return f"{bound[0]:g}" if np.all(bound == bound[0]) else str(bound.tolist())
