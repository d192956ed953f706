"""Sets that solutions do not leave: a half line, an orthant, a box, a simplex, a ball, or an author's own."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Mask

# Of a set that is not bounded, states are drawn of about this size.
SIZE = 1.0
# States by which it is told whether one set lies in another one, and the seed that they are drawn with.
STATES, SEED = 256, 20
# Rounding of a sum or norm of components.
ROUNDING = 1e-12
# Of the way to a state outside, until its last point inside is known to rounding.
BISECTIONS = 52
NONNEGATIVE = "nonnegative"


@dataclass(frozen=True, eq=False)
class Domain:
    """A set of states that the solution of a problem does not leave, or that a scheme is for.

    States at which steps are compared with the equation are taken from it. A scheme with a domain is put to problems
    alone whose own domain lies in it, and to trivial equations whose solutions stay in it.

    Attributes
    ----------
    name : str
        In words that follow "states with", such as ``x >= 0``.
    contains : callable, ndarray of shape (d, P) -> ndarray of bool, shape (P,)
        Which states are in it; rows in the order of the problem's Ito equation.
    sample : callable, (numpy.random.Generator, d, P) -> ndarray of shape (d, P)
        Random states in it, away from its boundary.
    nonnegative : bool
        Whether all components stay at or above 0: the problem then has the trait ``nonnegative``.
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
        """Return the states whose components are all at least 0; in one dimension the half line."""
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
        """Return the states whose components are at least 0 and have a sum of at most 1."""

        def contains(x: Array) -> Mask:
            return np.asarray((x >= 0.0).all(axis=0) & (x.sum(axis=0) <= 1.0 + ROUNDING))

        def sample(rng: np.random.Generator, d: int, count: int) -> Array:
            return rng.dirichlet(np.full(d + 1, 2.0), count).T[:d]

        return cls("x >= 0 and a sum of at most 1", contains, sample, nonnegative=True)

    @classmethod
    def ball(cls, radius: float) -> "Domain":
        """Return the states with |x| <= radius; what stays on a sphere has a constraint, see `SDE`."""

        def contains(x: Array) -> Mask:
            return np.asarray((x * x).sum(axis=0) <= radius**2 * (1.0 + ROUNDING))

        def sample(rng: np.random.Generator, d: int, count: int) -> Array:
            x = rng.standard_normal((d, count))
            return np.asarray(0.9 * radius * rng.uniform(size=count) ** (1.0 / d) * x / np.sqrt((x * x).sum(axis=0)))

        return cls(f"|x| <= {radius:g}", contains, sample)

    def repeated(self, count: int) -> "Domain":
        """Return the states whose blocks of components are all in it, such as a solution and its past."""

        def contains(x: Array) -> Mask:
            return np.asarray(np.all([self.contains(block) for block in np.split(x, count)], axis=0))

        def sample(rng: np.random.Generator, d: int, paths: int) -> Array:
            return np.concatenate([self.sample(rng, d // count, paths) for _ in range(count)])

        return Domain(self.name, contains, sample, nonnegative=self.nonnegative)

    def draw(self, d: int, count: int, seed: int = SEED) -> Array:
        """Return random states, shape (d, count), the same for the same seed.

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
        """Return the last points in it on the ways from some states to others.

        Parameters
        ----------
        x : ndarray, shape (d, P)
            States in it.
        y : ndarray, shape (d, P)
            Where the ways lead.
        """
        low, high = np.zeros(x.shape[1]), np.where(self.contains(y), 0.0, 1.0)
        for _ in range(BISECTIONS * bool(high.any())):
            middle = 0.5 * (low + high)
            inside = self.contains(x + middle * (y - x))
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return np.asarray(np.where(high > 0.0, x + low * (y - x), y))

    def keep(self, x: Array, before: Array) -> Array:
        """Return states, shape (d, P), those outside replaced by the ones they come from."""
        return np.asarray(np.where(self.contains(x), x, before))


def outside(problem: Any, x: Array) -> Mask:
    """Return which states of an Ito equation, shape (d, P), are not in the domain of a problem.

    Parameters
    ----------
    problem : Problem
        Without domain, no state is outside.
    x : ndarray, shape (d, P)
    """
    domain: Domain | None = problem.domain
    return np.zeros(x.shape[1], dtype=bool) if domain is None else ~domain.contains(x)


def why_not_within(problem: Any, domain: Domain | None) -> str:
    """Return that a problem does not say that its states stay in the domain of a scheme, or an empty string.

    Parameters
    ----------
    problem : Problem
    domain : Domain or None
        Of the scheme; None if it is for all states.
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
