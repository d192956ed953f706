"""Levy areas between Brownian motions, drawn given dW and its time integrals.

Over a step of length h, for each pair i < j,

    A_ij = (1/2) int_t^{t+h} (W_i(s) - W_i(t)) dW_j(s) - (W_j(s) - W_j(t)) dW_i(s)                   variance h^2/4,

and, with the first two time integrals H and K of W, which are independent of dW and of each other,

    A_ij = H_i dW_j - H_j dW_i + 12 (K_i H_j - K_j H_i) + C_ij,    E[C_ij | dW, H, K] = 0,    variance h^2/20:

the coefficients of W in Legendre polynomials of degree 1, 2 and 3, and a remainder. No method is known to draw C_ij
exactly together with the path. It is drawn as a normal variable of the right variance on the finest steps; longer
steps have the areas that follow from Chen's relation,

    A = A' + A'' + (1/2) (dW' x dW'' - dW'' x dW').

Thus the expectation, the variance and the covariances of A with products of dW, H and K are right at every level, to
rounding. Quantities that depend on the fourth cumulants of C have a relative error of 1/n in these over n finest
steps.
"""

import numpy as np

from ..arrays import Array

# Variance of C_ij in units of h^2.
REST = 1.0 / 20.0


def pairs(l: int) -> tuple[Array, Array]:
    """Return the indices i < j of the l (l - 1)/2 pairs, in the order (0, 1), (0, 2), ..., (1, 2), ..."""
    first, second = np.triu_indices(l, k=1)
    return first, second


def outer(a: Array, b: Array) -> Array:
    """Return a_i b_j - a_j b_i for each pair; shapes (..., l, P) -> (..., l (l - 1)/2, P)."""
    # One pair at a time: indexing with arrays copies four arrays of the size of the result.
    found = np.empty((*a.shape[:-2], a.shape[-2] * (a.shape[-2] - 1) // 2, a.shape[-1]))
    for place, (i, j) in enumerate(zip(*pairs(a.shape[-2]), strict=True)):
        np.multiply(a[..., i, :], b[..., j, :], out=found[..., place, :])
        found[..., place, :] -= a[..., j, :] * b[..., i, :]
    return found


def known_part(dW: Array, H: Array, K: Array) -> Array:
    """Return E[A | dW, H, K], shape (..., l (l - 1)/2, P).

    Parameters
    ----------
    dW, H, K : ndarray, shape (..., l, P)
        Increment, its first and its second time integral, as in `Increment`.
    """
    return outer(H, dW) + 12.0 * outer(K, H)


def join_areas(A: Array, dW: Array) -> Array:
    """Return the areas of steps joined in pairs, by Chen's relation; shape (2 n, m, P) -> (n, m, P)."""
    whole: Array = A[0::2] + A[1::2] + 0.5 * outer(dW[0::2], dW[1::2])
    return whole
