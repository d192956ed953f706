"""Friction and noise related by the fluctuation-dissipation theorem."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sdaeverify import Array, ParameterError, ProblemError
from sdaeverify.numerics import apply, product_transposed

from .._arguments import number


@dataclass(frozen=True, kw_only=True)
class Bath:
    """Friction and noise of temperature kT: sigma sigma^T = 2 kT gamma.

    Attributes
    ----------
    friction : float, array_like of shape (n, n), or callable
        gamma, symmetric and positive definite; if it depends on positions, r of shape (n, P) -> ndarray, shape (P,)
        or (n, n, P).
    kT : float
        Temperature times Boltzmann's constant, positive.
    noise : callable, r -> ndarray, shape (n, l, P) or (n, l, 1), optional
        sigma; by default a root of 2 kT gamma, triangular if gamma is a matrix.
    """

    friction: float | ArrayLike | Callable[[Array], Array]
    kT: float
    noise: Callable[[Array], Array] | None = None

    @property
    def constant(self) -> bool:
        """Whether sigma is known to be constant, because neither friction nor noise depends on the position."""
        return self.noise is None and not callable(self.friction)

    def gamma(self, r: Array) -> Array:
        """Return gamma in its given form: a number, shape () or (P,), or a matrix, shape (n, n, P) or (n, n, 1)."""
        value = np.asarray(self.friction(r) if callable(self.friction) else self.friction)
        return value[..., None] if value.ndim == 2 else value

    def drag(self, r: Array, v: Array) -> Array:
        """Return gamma v, shape (n, P)."""
        gamma = self.gamma(r)
        return gamma * v if gamma.ndim < 2 else apply(gamma, v)

    def sigma(self, r: Array) -> Array:
        """Return sigma, shape (n, l, P) or (n, l, 1)."""
        if self.noise is not None:
            return self.noise(r)
        size = 2.0 * self.kT * self.gamma(r)
        return np.sqrt(size) * np.eye(len(r))[..., None] if size.ndim < 2 else _triangular_root(size)

    def check(self, r: Array) -> None:
        """Check temperature, friction and their balance with the noise at a position, shape (n, 1).

        Raises
        ------
        ParameterError
            If kT is not positive, or gamma is not symmetric and positive definite.
        ProblemError
            If sigma sigma^T is not 2 kT gamma.
        """
        if not 0.0 < number("kT", self.kT) < np.inf:
            raise ParameterError(f"the temperature kT must be positive and finite, got {self.kT!r}")
        gamma, n = self.gamma(r), len(r)
        full = (gamma if gamma.ndim == 3 else gamma * np.eye(n)[..., None])[..., 0]
        if full.shape != (n, n) or not _positive(full):
            text = "friction must be a positive number or a symmetric positive definite matrix"
            raise ParameterError(f"{text} of shape ({n}, {n}), got {gamma[..., 0].tolist() if gamma.ndim else gamma}")
        sigma = self.sigma(r)
        square = product_transposed(sigma, sigma)[..., 0]
        if not np.allclose(square, 2.0 * self.kT * full, rtol=1e-12, atol=1e-14 * np.abs(square).max()):
            raise ProblemError(
                f"sigma sigma^T must be 2 kT gamma = {(2.0 * self.kT * full).tolist()}, got {square.tolist()}"
            )


def _positive(matrix: Array) -> bool:
    """Return whether a matrix is symmetric, up to rounding, and positive definite."""
    skew = np.abs(matrix - matrix.T).max()
    # NaN fails this comparison and is rejected.
    symmetric = skew <= 1e-14 * np.abs(matrix).max() < np.inf
    return bool(symmetric and np.linalg.eigvalsh(matrix)[0] > 0.0)


def _triangular_root(A: Array) -> Array:
    """Return L with L L^T = A on every path, shape (n, n, P), by elimination, which is analytic for complex steps."""
    columns = []
    for j in range(len(A)):
        columns.append(A[:, j] / np.sqrt(A[j, j]))
        A = A - columns[-1][:, None] * columns[-1][None]
    return np.stack(columns, axis=1)
