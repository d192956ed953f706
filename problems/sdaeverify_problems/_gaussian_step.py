"""The exact solution of a linear equation dz = A z dt + B dW over one step, on a given Brownian path."""

from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array


class GaussianStep(NamedTuple):
    """One step z+ = propagator z + of_dW dW + of_H H + of_xi xi with k additional normals xi, z in R^k and W in R^l.

    Attributes
    ----------
    propagator, of_xi : ndarray, shape (k, k)
    of_dW, of_H : ndarray, shape (k, l)
    """

    propagator: Array
    of_dW: Array
    of_H: Array
    of_xi: Array


def gaussian_step(A: Array, B: Array, h: float) -> GaussianStep:
    """Return the coefficients of int_0^h e^{(h-s)A} B dW(s) = alpha dW + beta H + sqrt(h) rho xi.

    With q = (h-s)/h, the kernels of dW and H on [0, h] are 1 and q - 1/2, which are orthogonal: alpha and beta are
    the projections of e^{qhA} B, by a quadrature that is exact to rounding for |hA| <= 4, and rho rho^T is the
    integral over q of R R^T with the remainder R of the projection. The factor rho is computed from values of R,
    because the difference of covariances suffers from cancellation.

    Parameters
    ----------
    A : ndarray, shape (k, k)
    B : ndarray, shape (k, l)
    h : float

    Returns
    -------
    GaussianStep
    """
    nodes, weights = np.polynomial.legendre.leggauss(16)
    q, w = 0.5 + 0.5 * nodes, 0.5 * weights
    alpha, beta, rho = project_kernel(np.stack([scipy.linalg.expm(x * h * A) @ B for x in q]), q, w)
    return GaussianStep(scipy.linalg.expm(h * A), alpha, beta, np.sqrt(h) * rho)


def project_kernel(kernel: Array, q: Array, w: Array) -> tuple[Array, Array, Array]:
    """Return alpha, beta and rho of a kernel at the nodes q of a quadrature on [0, 1] with weights w.

    Parameters
    ----------
    kernel : ndarray, shape (K, k, l)
    q, w : ndarray, shape (K,)

    Returns
    -------
    alpha, beta : ndarray, shape (k, l)
    rho : ndarray, shape (k, k)
    """
    alpha = np.tensordot(w, kernel, 1)
    beta = 12.0 * np.tensordot(w * (q - 0.5), kernel, 1)
    rest = kernel - alpha - beta * (q - 0.5)[:, None, None]
    stacked = np.concatenate(np.sqrt(w)[:, None, None] * np.swapaxes(rest, 1, 2))
    return alpha, beta, np.linalg.qr(stacked, mode="r").T
