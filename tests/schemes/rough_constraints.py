"""Constraints without any symmetry, their derivatives for one point, and Langevin dynamics on them."""

from functools import cache
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, ConstrainedLangevin

D, SIGMA = 4, 0.8


class Rough(NamedTuple):
    """zeta_k = c_k x + x Q_k x / 2 + (a_k x)^3 / 6, which vanishes at 0.

    Attributes
    ----------
    c, a : ndarray, shape (q, d)
    Q : ndarray, shape (q, d, d)
        Symmetric.
    """

    c: Array
    a: Array
    Q: Array

    def zeta(self, x: Array) -> Array:
        """Return zeta at points of shape (d, P) or (d,)."""
        bent = 0.5 * np.einsum("i...,kij,j...->k...", x, self.Q, x)
        return np.tensordot(self.c, x, 1) + bent + np.tensordot(self.a, x, 1) ** 3 / 6.0

    def jacobian(self, x: Array) -> Array:
        """Return g^T, shape (q, d, P)."""
        return self.c[..., None] + np.tensordot(self.Q, x, 1) + 0.5 * ((self.a @ x) ** 2)[:, None] * self.a[..., None]

    def second(self, x: Array, A: Array) -> Array:
        """Return sum_k H_k A_k, shape (d, P)."""
        aA = np.einsum("kp,ki,ikp->kp", self.a @ x, self.a, A)
        return np.einsum("kij,jkp->ip", self.Q, A) + np.einsum("kp,ki->ip", aA, self.a)

    def gradient(self, x: Array) -> Array:
        """Return g at one point, shape (d, q)."""
        return (self.c + self.Q @ x + 0.5 * (self.a @ x)[:, None] ** 2 * self.a).T

    def hessians(self, x: Array) -> Array:
        """Return H_k at one point, shape (q, d, d)."""
        return self.Q + (self.a @ x)[:, None, None] * self.a[:, :, None] * self.a[:, None]


@cache
def rough(q: int) -> Rough:
    rng = np.random.default_rng(q)
    Q = 0.3 * rng.standard_normal((q, D, D))
    return Rough(
        np.eye(D)[:q] + 0.4 * rng.standard_normal((q, D)), 0.7 * rng.standard_normal((q, D)), Q + Q.swapaxes(1, 2)
    )


def drift(x: Array) -> Array:
    return np.cos(x[::-1]) - x


@cache
def langevin(q: int, eps: float, **changes: object) -> ConstrainedLangevin:
    """Return dynamics near the q rough constraints."""
    given = {
        "drift": drift,
        "strength": SIGMA,
        "eps": eps,
        "constraint": rough(q).zeta,
        "jacobian": rough(q).jacobian,
        "second": rough(q).second,
        "start": np.zeros(D),
        "horizon": 1.0,
        "source": "made up",
    }
    return ConstrainedLangevin(**{**given, **changes})


def points(q: int, distance: float, count: int = 5) -> Array:
    """Return points near the manifold, and beside it by about so much, shape (d, P)."""
    rng = np.random.default_rng(10 + q)
    on = langevin(q, 0.0).admissible(0.2 * rng.standard_normal((D, count)))
    return on + distance * rng.uniform(-1.0, 1.0, on.shape)
