"""Comparison of two cubature rules for the noise of a step.

The second one has many random nodes, or is the first one rotated if there are many variables. Both are exact for
polynomials up to their degree. For a step with a jump or kink as a function of its noise, the means differ, because
the rules share no node except 0.
"""

from functools import lru_cache
from itertools import product

import numpy as np
import scipy

from ...arrays import Array

# Two rules agree on an error if their results differ by at most this part of it. On errors with leading term |N| they
# differ by 0.14, with few nodes per variable by 0.33 (balanced-euler on fibre-linear). If a right step transforms its
# noise, the error is that of the rule, and they differ by at least 0.40, mostly by almost all of it
# (tests/probe/own_noise.py).
# Measured by tests/probe/own_noise.py.
AGREEMENT = 0.36
# Remedy for the author of a scheme whose step has means that depend on the rule.
SHAPED = (
    "a step is not a polynomial of its noise; a scheme that transforms its noise must declare a law or set "
    "discontinuous_in_noise"
)
# Degree and number of random nodes by the number of variables. A region with a share of 1/100 of the noise is missed
# with probability 0.99^512 = 0.006.
# Theorem: terms of order h^(k/2) of a step are polynomials of degree k, so that degree 5 gives means up to order 2.
SCATTERED = {1: (11, 512), 2: (7, 768), 3: (5, 1024), 4: (5, 1024)}
# Number of orthogonal matrices from which one is selected, and the key of the first.
# Size: matrices; any seed.
TURNS, KEY = 32, 20170701


def turn(n: int, key: int) -> Array:
    """Return a random orthogonal matrix: rotation of a rule for independent normals preserves its degree.

    Parameters
    ----------
    n : int
        Number of rows.
    key : int
        Key of the random number generator.
    """
    Q, _ = np.linalg.qr(np.random.Generator(np.random.Philox(key=key)).standard_normal((n, n)))
    return np.asarray(Q)


@lru_cache(maxsize=16)
def mixing_turn(n: int) -> Array:
    """Return the orthogonal matrix, of several random ones, that is farthest from a permutation of the axes.

    A random matrix with three rows may have an entry of 0.95. With a rule rotated by such a matrix, a step with a
    jump in each variable would have the same means as with the rule itself.

    Parameters
    ----------
    n : int
        Number of rows.
    """
    return min((turn(n, KEY + k) for k in range(TURNS)), key=lambda Q: float(np.abs(Q).max()))


@lru_cache(maxsize=4)
def scattered(n: int, degree: int, count: int) -> tuple[Array, Array]:
    """Return random normal nodes with weights that make the means of all polynomials up to a degree exact.

    Each variable has a value in each of K/2 equally probable intervals (McKay, Beckman & Conover 1979). With each
    node x comes -x, so that means of odd functions are 0. Of all such weights they are nearest to 1/K, the solution
    of least norm of V w = e_0, where the rows of V are the products of Hermite polynomials, of mean 0 but for the
    first, at the K nodes.

    Parameters
    ----------
    n : int
        Number of variables.
    degree : int
    count : int
        Even number K of nodes.

    Returns
    -------
    ndarray, shape (n, K)
    ndarray, shape (K,)
    """
    rng = np.random.Generator(np.random.Philox(key=KEY + TURNS))
    places = rng.permuted(np.tile(np.arange(count // 2), (n, 1)), axis=1)
    half = scipy.special.ndtri((places + rng.uniform(size=places.shape)) / (count // 2))
    x = np.concatenate([half, -half], axis=1)
    sizes = np.sqrt(scipy.special.factorial(np.arange(degree + 1.0)))
    hermite = np.polynomial.hermite_e.hermevander(x, degree) / sizes
    powers = [each for each in product(range(degree + 1), repeat=n) if sum(each) <= degree]
    rows = np.stack([np.prod([hermite[i, :, k] for i, k in enumerate(each)], axis=0) for each in powers])
    wanted = np.array([float(not any(each)) for each in powers])
    weights = np.full(count, 1.0 / count)
    return x, weights + np.linalg.lstsq(rows, wanted - rows @ weights, rcond=None)[0]
