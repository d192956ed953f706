"""Comparison of two cubature rules for the noise of a step, one of which is the other rotated.

Both are exact for polynomials up to their degree. For a step with a jump or kink as a function of its noise, the
means differ, because the rules share no node except 0.
"""

from functools import lru_cache

import numpy as np

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
