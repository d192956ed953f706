"""Laws of dynamics near or on the unit sphere of R^d with a constant drift f = pull e_1, the von Mises-Fisher law.

For eps > 0 the invariant density is |x|^(2 a - d) exp(-|x|^2/(2 sigma^2 eps) + k x_1) with k = 2 pull/sigma^2 and
a = (d + 1 + 1/(sigma^2 eps))/2. With z = sigma^2 eps k^2/2 its power series in x_1 is a mixture over n = 0, 1, ...

    p_n ~ (a)_n z^n / ((d/2)_n n!),      |X|^2 = 2 sigma^2 eps Gamma(a + n),
    E x_1 = (2/k) E n,    E x_1^2 = E 2n (2n - 1)/k^2,

where the p_n are proportional to the terms of the series of 1F1(a; d/2; z), which are positive.
"""

from math import nan

import numpy as np
import scipy

from sdaeverify import Array

from .._interval_diffusion import IntervalDiffusion

MOST_TERMS = 2**20


def invariant_means(eps: float, d: int, sigma: float, pull: float) -> dict[str, float]:
    """Return the means of x_1, x_1^2, |x|^2 and |x|^4 under the invariant law.

    The means are NaN if the penalty is so weak that the series is too long; its length is of the order of
    z = 2 eps (pull/sigma)^2.
    """
    k = 2.0 * pull / sigma**2
    if eps == 0.0:
        first = float(scipy.special.ive(0.5 * d, abs(k)) / scipy.special.ive(0.5 * d - 1.0, abs(k)) * np.sign(k))
        return {"x_1": first, "x_1^2": 1.0 - (d - 1.0) * first / k, "|x|^2": 1.0, "|x|^4": 1.0}
    a, z = 0.5 * (d + 1.0 + 1.0 / (sigma**2 * eps)), 0.5 * sigma**2 * eps * k**2
    last = 60.0 + 4.0 * (z + np.sqrt(a * z))
    if not last < MOST_TERMS:
        return dict.fromkeys(("x_1", "x_1^2", "|x|^2", "|x|^4"), nan)
    n, p = _mixture(a, 0.5 * d, z, last)
    scale = 2.0 * sigma**2 * eps
    square = scale * (a + n)
    return {
        "x_1": 2.0 / k * float(p @ n),
        "x_1^2": float(p @ (2.0 * n * (2.0 * n - 1.0))) / k**2,
        "|x|^2": float(p @ square),
        "|x|^4": float(p @ (square * (square + scale))),
    }


def on_the_sphere(d: int, sigma: float, pull: float) -> IntervalDiffusion:
    """Return the diffusion of u = x_1 in the limit eps = 0.

    The generator (sigma^2/2) [(1 - u^2) D^2 - (d - 1) u D] + pull (1 - u^2) D is reversible for
    (1 - u^2)^((d-3)/2) e^{k u}.
    """
    k = 2.0 * pull / sigma**2
    count = 32 + int(np.ceil(abs(k)))
    u, w = scipy.special.roots_jacobi(2 * count, 0.5 * (d - 3.0), 0.5 * (d - 3.0))
    weights = w * np.exp(k * u - abs(k))
    return IntervalDiffusion(u, weights / weights.sum(), 0.5 * sigma**2 * (1.0 - u * u), count)


def _mixture(a: float, b: float, z: float, last: float) -> tuple[Array, Array]:
    """Return n and p_n ~ (a)_n z^n / ((b)_n n!) for n < `last`, beyond which the terms are negligible."""
    n = np.arange(np.ceil(last))
    logs = np.concatenate([[0.0], np.cumsum(np.log((a + n) * z / ((b + n) * (n + 1.0))))])[: len(n)]
    p = np.exp(logs - logs.max())
    return n, p / p.sum()
