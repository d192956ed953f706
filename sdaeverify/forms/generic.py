"""Classes of equations of a form from which random members are drawn.

Let a step be an analytic function of the values that the coefficients take at finitely many stage points. Each term
of its local defect is then a polynomial in finitely many derivatives of the coefficients at the state. The
derivatives that a form admits are the image of a connected open set of free parameters under an analytic map. A
polynomial that does not vanish identically on this image vanishes on a set of measure zero. So a member drawn
from a law with a density shows every wrong coefficient with probability one.
"""

import hashlib
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import ProblemError

Generator = np.random.Generator
# Maximum number of draws until a member is consistent.
DRAWS = 20
# Range of the absolute values of polynomial coefficients; signs are random.
SMALLEST, LARGEST = 0.2, 0.5
# Range of the singular values of linear parts that must be regular.
WEAKEST, STRONGEST = 1.0, 2.0
# Degree of Taylor polynomials: a claim of order p needs derivatives up to p + 2.
DEGREE = 3


@dataclass(frozen=True)
class GenericClass:
    """A class of equations of a form, with a law from which its members are drawn.

    Attributes
    ----------
    name : str
        Of the class, for users.
    draw : callable, (Generator, frozenset of str) -> Problem
        Draws a member without the given features.
    features : mapping of str to str
        Parts of the equation that can be omitted: the name, and a text that continues "only with", such as
        ``a mass matrix``. A member without a feature declares the traits that follow from this.
    mistakes : tuple
        Known mistakes in the equation, each with a ``sentence`` and ``coefficients(problem, t, x)``, the drift and
        the diffusion that it makes of a member, as those of `mechanics.mistakes`.
    """

    name: str
    draw: Callable[[Generator, frozenset[str]], Any] = field(compare=False)
    features: Mapping[str, str] = field(default_factory=dict, compare=False)
    mistakes: tuple[Any, ...] = field(default=(), compare=False)

    def member(self, seed: int, index: int, without: Collection[str] = ()) -> Any:
        """Draw a random problem of the class, the same for the same arguments.

        Parameters
        ----------
        seed : int
        index : int
            Members with other indices are independent draws.
        without : collection of str
            Names of features to omit.

        Raises
        ------
        ProblemError
            If no draw is a consistent problem.
        """
        digest = hashlib.blake2b(f"{seed}|{self.name}|{index}".encode(), digest_size=16).digest()
        rng = np.random.Generator(np.random.Philox(key=np.frombuffer(digest, dtype=np.uint64)))
        for _ in range(DRAWS - 1):
            try:
                return self.draw(rng, frozenset(without))
            except ProblemError:
                continue
        return self.draw(rng, frozenset(without))


class Polynomial(NamedTuple):
    """A polynomial map R^n -> R^m in monomials of u = z - centre.

    Attributes
    ----------
    powers : tuple of tuple of int
        The factors of each monomial, as `monomials_of` returns them.
    coefficients : ndarray, shape (m, N)
    centre : ndarray, shape (n,)
    """

    powers: tuple[tuple[int, ...], ...]
    coefficients: Array
    centre: Array

    def __call__(self, z: Array) -> Array:
        """Return the values, shape (m, P), at z of shape (n, P)."""
        u = z - self.centre[:, None]
        blocks = [np.ones((1, z.shape[1]), dtype=u.dtype)]
        for before, last in _factors(len(u), len(self.powers[-1])):
            blocks.append(blocks[-1][before] * u[last])
        return np.asarray(self.coefficients @ np.concatenate(blocks))

    @property
    def derivative(self) -> "Polynomial":
        """The derivative: of component i by variable k, in row n i + k."""
        n, degree = len(self.centre), max(map(len, self.powers))
        powers = monomials_of(n, max(degree - 1, 0))
        places = {each: place for place, each in enumerate(powers)}
        found = np.zeros((len(self.coefficients), n, len(powers)))
        for column, factors in enumerate(self.powers):
            for k in set(factors):
                rest = list(factors)
                rest.remove(k)
                found[:, k, places[tuple(rest)]] += factors.count(k) * self.coefficients[:, column]
        return Polynomial(powers, found.reshape(-1, len(powers)), self.centre)

    def without(self, *variables: int) -> "Polynomial":
        """Return the polynomial without the terms that contain any of the given variables."""
        kept = [not set(variables) & set(powers) for powers in self.powers]
        return self._replace(coefficients=self.coefficients * kept)

    def up_to(self, degree: int) -> "Polynomial":
        """Return the polynomial truncated to a degree."""
        return self._replace(coefficients=self.coefficients * [len(powers) <= degree for powers in self.powers])


@lru_cache(maxsize=32)
def monomials_of(n: int, degree: int) -> tuple[tuple[int, ...], ...]:
    """Return the factors of all monomials in n variables up to a degree, by ascending degree."""
    degrees = range(degree + 1)
    return tuple(powers for each in degrees for powers in combinations_with_replacement(range(n), each))


@lru_cache(maxsize=32)
def _factors(n: int, degree: int) -> tuple[tuple[Array, Array], ...]:
    """Return, for each degree from 1 on, the index of each monomial without its last factor, and this factor."""
    found = []
    for each in range(1, degree + 1):
        places = {powers: place for place, powers in enumerate(combinations_with_replacement(range(n), each - 1))}
        these = [*combinations_with_replacement(range(n), each)]
        found.append(
            (np.array([places[powers[:-1]] for powers in these]), np.array([powers[-1] for powers in these]))
        )
    return tuple(found)


def draw_polynomial(rng: Generator, centre: Array, rows: int, degree: int = DEGREE) -> Polynomial:
    """Draw a polynomial whose coefficients have a density.

    Parameters
    ----------
    rng : numpy.random.Generator
    centre : ndarray, shape (n,)
    rows : int
        Number m of components.
    degree : int
    """
    powers, n = monomials_of(len(centre), degree), len(centre)
    # With these sizes, derivatives of all orders in a random direction have size 1.
    sizes = [float(n) ** (-0.5 * max(len(each) - 1, 0)) for each in powers]
    return Polynomial(powers, draw_signed(rng, (rows, len(powers))) * sizes, centre)


def draw_signed(rng: Generator, shape: tuple[int, ...]) -> Array:
    """Draw numbers with absolute values between 0.2 and 0.5 and random signs."""
    return np.asarray(rng.choice([-1.0, 1.0], shape) * rng.uniform(SMALLEST, LARGEST, shape))


def draw_regular(rng: Generator, rows: int, columns: int) -> Array:
    """Draw a matrix with singular values between 1 and 2.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of random numbers.
    rows, columns : int
        Shape of the matrix.

    Returns
    -------
    ndarray, shape (rows, columns)
    """
    small = min(rows, columns)
    left, right = (np.linalg.qr(rng.standard_normal((size, small)))[0] for size in (rows, columns))
    return np.asarray(left * rng.uniform(WEAKEST, STRONGEST, small) @ right.T)


def with_linear_part(f: Polynomial, A: Array) -> Polynomial:
    """Return a polynomial that vanishes at its centre and has the derivative A there, shape (m, n).

    Parameters
    ----------
    f : Polynomial
        Polynomial that provides the terms of degree 2 and higher.
    A : ndarray, shape (m, n)
    """
    coefficients = f.coefficients.copy()
    coefficients[:, 0], coefficients[:, 1 : 1 + len(f.centre)] = 0.0, A
    return f._replace(coefficients=coefficients)


def draw_near(rng: Generator, centre: Array, count: int, radius: float) -> Array:
    """Draw points near a centre.

    Parameters
    ----------
    rng : numpy.random.Generator
    centre : ndarray, shape (n,)
    count : int
    radius : float
        Largest distance from the centre in each component.

    Returns
    -------
    ndarray, shape (n, count)
    """
    return np.asarray(centre[:, None] + radius * rng.uniform(-1.0, 1.0, (len(centre), count)))
