"""The equation given to a step at some points, its rates, and those that a mistake makes of them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Equation

# Words: relative accuracy of the limits of rates with an expansion in h, and the smallest relative deviation that
# counts as a mistake.
RESOLUTION, DEFECT = 2e-5, 1e-3
# Words: relative step of the difference quotients of the diffusion along its columns.
ALONG = 1e-5


class Rates(NamedTuple):
    """Rates of mean and square of an equation, or of short steps, at n points.

    Attributes
    ----------
    f : ndarray, shape (d, n)
    Q : ndarray, shape (d, d, n)
    """

    f: Array
    Q: Array


@dataclass(frozen=True, eq=False)
class Given:
    """The equation given to a step, at n points of one time.

    Attributes
    ----------
    equation : Equation
    t : float
    x : ndarray, shape (d, n)
    """

    equation: Equation
    t: float
    x: Array

    def drift(self, t: float | None = None, x: Array | None = None) -> Array:
        """Return f, shape (d, n), by default at the points and their time."""
        at = self.x if x is None else x
        return np.broadcast_to(self.equation.drift(self.t if t is None else t, at), at.shape)

    def diffusion(self, t: float | None = None, x: Array | None = None) -> Array:
        """Return B, shape (d, l, n), by default at the points and their time."""
        at = self.x if x is None else x
        B = self.equation.diffusion(self.t if t is None else t, at)
        return np.broadcast_to(B, (len(at), self.equation.noise_dim, at.shape[1]))

    @cached_property
    def correction(self) -> Array:
        """Half the sum of DB_j B_j, the difference between the drifts of Ito and Stratonovich, shape (d, n)."""
        total = np.zeros(self.x.shape)
        for j in range(self.equation.noise_dim):
            column = self.diffusion()[:, j]
            eps = ALONG * (1.0 + np.abs(self.x).max()) / (1.0 + np.abs(column).max())
            ahead, behind = (self.diffusion(x=self.x + sign * eps * column)[:, j] for sign in (1.0, -1.0))
            total += (ahead - behind) / (4.0 * eps)
        return total

    @property
    def rates(self) -> Rates:
        """Rates f and B B^T of the equation at the points."""
        return Rates(self.drift(), squares(self.diffusion()))


class Mistake(NamedTuple):
    """A mistake and the rates that result from it.

    Attributes
    ----------
    drift, noise : callable, Given -> ndarray, or None
        Return f_0, shape (d, n), and columns whose squares are Q_0, shape (d, l, n); None if unchanged.
    sentence : str
    """

    drift: Callable[[Given], Array] | None
    noise: Callable[[Given], Array] | None
    sentence: str

    @property
    def changes(self) -> int:
        """Number of changed coefficients, of drift and diffusion."""
        return (self.drift is not None) + (self.noise is not None)

    def rates(self, of: Given) -> Rates:
        """Return the rates that result from the mistake."""
        f = self.drift(of) if self.drift else of.drift()
        return Rates(f, squares(self.noise(of) if self.noise else of.diffusion()))


def squares(B: Array) -> Array:
    """Return B B^T, shape (d, d, n), of B of shape (d, l, n)."""
    return np.asarray(np.einsum("ikn,jkn->ijn", B, B))


def near(a: Array, b: Array, tolerance: float, right: Array) -> bool:
    """Return whether two arrays agree at all points, relative to both and to a third one.

    Parameters
    ----------
    a, b : ndarray, shape (..., n)
    tolerance : float
        Largest deviation, relative to the sizes at a point and to a thousandth of the largest ones.
    right : ndarray, shape (..., n)
    """
    axes = tuple(range(a.ndim - 1))
    size = np.abs(a).max(axis=axes) + np.abs(b).max(axis=axes) + np.abs(right).max(axis=axes)
    return bool((np.abs(a - b).max(axis=axes) <= tolerance * (size + 1e-3 * size.max(initial=0.0))).all())
