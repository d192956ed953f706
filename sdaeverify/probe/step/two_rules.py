"""Two rules for the noise of a step: what a rule and the same one turned by an orthogonal matrix say of its means.

Both are exact for polynomials up to their degree. The means of a step that jumps or bends as a function of its noise
differ, because the rules share no node but 0.
"""

from functools import lru_cache

import numpy as np

from ...arrays import Array

# Two rules agree on an error if they give it to this part of it. On errors led by |N| they differ by 0.14, with few
# nodes a variable by 0.33 (balanced-euler on fibre-linear). Where a right step shapes its noise, the error is that of
# a rule, and they differ by 0.40 at least, in most cases by about all of it (tests/probe/own_noise.py).
# Measured by tests/probe/own_noise.py.
AGREEMENT = 0.36
# What the author of a scheme can do about a step whose means depend on the rule.
SHAPED = (
    "a step is no polynomial of its noise; a scheme that shapes its own noise declares it as its law, or sets "
    "discontinuous_in_noise"
)
# Orthogonal matrices of which one turns a rule, and the key of the first.
# Size: matrices; any seed.
TURNS, KEY = 32, 20170701


def turn(n: int, key: int) -> Array:
    """Return an orthogonal matrix: a rule for independent normals is exact to the same degree when it is turned.

    Parameters
    ----------
    n : int
        Number of rows.
    key : int
        Of the random numbers that it is made of.
    """
    Q, _ = np.linalg.qr(np.random.Generator(np.random.Philox(key=key)).standard_normal((n, n)))
    return np.asarray(Q)


@lru_cache(maxsize=16)
def mixing_turn(n: int) -> Array:
    """Return the one of some orthogonal matrices that is farthest from a permutation of the axes.

    A random matrix of three rows may be as near to one as 0.95 is to 1. A step that jumps as a function of each
    variable has the same means by a rule and by the rule that such a matrix turns.

    Parameters
    ----------
    n : int
        Number of rows.
    """
    return min((turn(n, KEY + k) for k in range(TURNS)), key=lambda Q: float(np.abs(Q).max()))
