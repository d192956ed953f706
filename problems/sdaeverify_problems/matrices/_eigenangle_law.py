"""Invariant law exp(a tr Q), a = 2 kappa/sigma^2, on SO(m) with f = -kappa (x - Id), in terms of eigenangles.

With z_k = 1 - cos theta_k for the m // 2 pairs of eigenvalues e^{+-i theta_k}, tr Q = m - 2 sum_k z_k and Weyl's
law is

    prod_{j<k} (z_j - z_k)^2 prod_k z_k^{m mod 2} exp(-2 a z_k) dtheta_k.
"""

import numpy as np

from sdaeverify import Array

from .._interval_diffusion import IntervalDiffusion

# The weight in y = cos theta varies by e^{4 a}: polynomials in y are used for a up to STRONGEST, else in a scaled z.
ANGLES, POLYNOMIALS, STRONGEST, FARTHEST = 2048, 48, 5.0, 1e3


def mean_trace(m: int, a: float) -> float:
    """Return E tr Q under the invariant law, for a up to 1e4.

    The z_k are an orthogonal polynomial ensemble: the mean of their sum is the trace of the multiplication by z on
    polynomials of degree below m // 2, in an orthonormal basis.
    """
    y, weights = _angles(m, a)
    z = 1.0 - y
    scaled = np.minimum(z * max(a, 1.0), FARTHEST)
    vectors = np.sqrt(weights)[:, None] * np.polynomial.polynomial.polyvander(scaled, m // 2 - 1)
    basis = np.linalg.qr(vectors)[0]
    return m - 2.0 * float((basis * basis).sum(axis=1) @ z)


def single_angle(m: int, a: float, sigma: float) -> IntervalDiffusion:
    """Return the diffusion of cos theta for m = 2 and 3, a up to `STRONGEST`; |dQ|^2 = 2 dtheta^2 along it."""
    y, weights = _angles(m, a)
    return IntervalDiffusion(y, weights, 0.25 * sigma**2 * (1.0 - y * y), POLYNOMIALS)


def _angles(m: int, a: float) -> tuple[Array, Array]:
    y = np.cos(np.pi * (np.arange(ANGLES) + 0.5) / ANGLES)
    weights = (1.0 - y) ** (m % 2) * np.exp(2.0 * a * (y - 1.0))
    return y, weights / weights.sum()
