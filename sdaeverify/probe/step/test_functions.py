"""Test functions phi of the weak tests, evaluated on all paths at once.

All monomials to degree 3 in up to three variables, to degree 2 beyond; x_i^4, sin(sum x) and exp(-|x|^2/2).
"""

from itertools import combinations_with_replacement

import numpy as np

from ...arrays import Array

# Largest number of variables for which monomials of degree 3 are included.
# Size: number of test functions.
FEW = 3


def names(dimension: int) -> tuple[str, ...]:
    """Return the test functions as text, in the order of `values`."""
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
    d, places = len(x), {powers: place for place, powers in enumerate(_powers(len(x)))}
    found = np.empty((len(places) + d + 2, *x.shape[1:]), dtype=np.result_type(x, float))
    found[:d] = x
    # Written in place: for many components they take many megabytes.
    for powers, place in places.items():
        if len(powers) > 1:
            np.multiply(found[places[powers[:-1]]], x[powers[-1]], out=found[place])
    squares = [found[places[i, i]] for i in range(d)]
    for i, square in enumerate(squares):
        np.multiply(square, square, out=found[len(places) + i])
    found[-2], found[-1] = np.sin(x.sum(axis=0)), np.exp(-0.5 * sum(squares))
    return found


def coefficients(linear: Array, square: Array, units: Array) -> Array:
    """Return the coefficients that express l . x + x^T S x in the test functions of x/u, shape (F,).

    Parameters
    ----------
    linear, square : ndarray, shape (d,) and (d, d)
        l and S.
    units : ndarray, shape (d,)
        Units u by which the components are divided.
    """
    d, scaled = len(units), square * np.outer(units, units)
    found = np.zeros(len(names(d)))
    for place, powers in enumerate(_powers(d)):
        if len(powers) == 1:
            found[place] = linear[powers[0]] * units[powers[0]]
        elif len(powers) == 2:
            i, j = powers
            found[place] = scaled[i, j] * (1.0 if i == j else 2.0)
    return found


def _powers(dimension: int) -> tuple[tuple[int, ...], ...]:
    degrees = range(1, 4 if dimension <= FEW else 3)
    return tuple(powers for degree in degrees for powers in combinations_with_replacement(range(dimension), degree))
