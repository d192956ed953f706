"""The unit sphere g(r) = (1 - |r|^2)/2 in R^n."""

import numpy as np

from sdaeverify import Array

from ..curves._circle import EPS


def squared_norm(x: Array) -> Array:
    """Return |x|^2, shape (n, ...) -> (...)."""
    return np.asarray((x * x).sum(axis=0))


def constraint(r: Array) -> Array:
    """Return g(r) = (1 - |r|^2)/2, shape (1, P)."""
    return np.asarray(0.5 * (1.0 - squared_norm(r))[None])


def jacobian(r: Array) -> Array:
    """Return Dg(r) = -r^T, shape (1, n, P)."""
    return -r[None]


def curvature(r: Array, y: Array, z: Array) -> Array:
    """Return D^2 g(r)(y, z) = -<y, z>, shape (1, P)."""
    return np.asarray(-(y * z).sum(axis=0)[None])


def constraint_bound(mass: Array, eps: float = EPS) -> float:
    """Return C_g of Lindner & Stroot (2.7) on the eps-neighbourhood of the sphere.

    If the eigenvalues of M are between l_min and l_max, G_M = r^T M^{-1} r is between (1 - eps)^2/l_max and
    (1 + eps)^2/l_min; the latter also bounds |M^{-1} r|, and |D^2 g| = 1.

    Parameters
    ----------
    mass : ndarray, shape (n, n)
        Mass matrix M.
    eps : float, optional
        Relative width of the neighbourhood, between 0 and 1.

    Returns
    -------
    float
    """
    eigenvalues = np.linalg.eigvalsh(mass)
    return float(max((1.0 + eps) ** 2 / eigenvalues[0], eigenvalues[-1] / (1.0 - eps) ** 2, 1.0))
