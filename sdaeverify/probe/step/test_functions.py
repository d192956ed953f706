"""Test functions phi of the weak tests, evaluated on all paths at once.

All monomials to degree 3 in up to three variables, to degree 2 beyond; x_i^4, sin(sum x) and exp(-|x|^2/2).
"""

from itertools import combinations_with_replacement

import numpy as np

from ...arrays import Array

# In more variables than this, monomials end at degree 2.
FEW = 3


def names(dimension: int) -> tuple[str, ...]:
    """Return the test functions in words, in the order of `values`."""
    monomials = [" ".join(f"x{i + 1}" for i in powers) for powers in _powers(dimension)]
    return (*monomials, *(f"x{i + 1}^4" for i in range(dimension)), "sin(sum x)", "exp(-|x|^2/2)")


def values(x: Array) -> Array:
    """Return phi(x) of every test function.

    Parameters
    ----------
    x : ndarray, shape (d, P)

    Returns
    -------
    ndarray, shape (F, P)
    """
    monomials: dict[tuple[int, ...], Array] = {}
    for powers in _powers(len(x)):
        monomials[powers] = monomials[powers[:-1]] * x[powers[-1]] if len(powers) > 1 else x[powers[0]]
    squares = [monomials[i, i] for i in range(len(x))]
    total, square = x.sum(axis=0), sum(squares)
    return np.stack([*monomials.values(), *(s * s for s in squares), np.sin(total), np.exp(-0.5 * square)])


def _powers(dimension: int) -> list[tuple[int, ...]]:
    degrees = range(1, 4 if dimension <= FEW else 3)
    return [powers for degree in degrees for powers in combinations_with_replacement(range(dimension), degree)]
