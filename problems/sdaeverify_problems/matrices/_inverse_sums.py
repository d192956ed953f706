"""A function of symmetric matrices without their eigenvalues."""

from collections.abc import Mapping, Sequence

import numpy as np

from sdaeverify import Array
from sdaeverify.numerics import eliminated

from ._lyapunov import product


def inverse_sums(C: Array) -> Array:
    """Return sum_j (C + c_j Id)^{-1} without eigenvalues, shape (p, p, P); from j = i it has C^{-1}/2.

    It is N D^{-1} with D = prod_j (C + c_j Id) = 2 sum_{k odd} e_k C^{p - k}, by Cayley and Hamilton, and its
    derivative N = sum_{k < p} (p - k) e_k C^{p - k - 1}; e_k are the elementary symmetric functions of the c_j, by
    Newton's identities k e_k = sum_{i = 1..k} (-1)^{i - 1} e_{k - i} tr C^i.
    """
    p, powers = len(C), [C]
    for _ in range(p - 2):
        powers.append(product(powers[-1], C))
    traces = [np.einsum("iiP->P", power) for power in powers] + [np.einsum("ijP,ijP->P", powers[-1], C)]
    e = [np.ones_like(traces[0])]
    for k in range(1, p + 1):
        e.append(sum((-1.0) ** i * e[k - 1 - i] * traces[i] for i in range(k)) / k)
    N = polynomial({p - k - 1: (p - k) * e[k] for k in range(p)}, powers)
    D = polynomial({p - k: 2.0 * e[k] for k in range(1, p + 1, 2)}, powers)
    return eliminated(D).solve(N)


def polynomial(coefficients: Mapping[int, Array], powers: Sequence[Array]) -> Array:
    """Return the sum of coefficients, shape (P,), times powers 0, 1, ... of a matrix, given from the first on."""
    total, places = np.zeros_like(powers[0]), np.arange(len(powers[0]))
    for n, coefficient in coefficients.items():
        if n:
            total += coefficient * powers[n - 1]
        else:
            total[places, places] += coefficient
    return total
