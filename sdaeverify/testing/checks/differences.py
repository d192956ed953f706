"""Derivatives by central differences of order eight, independent of complex steps and exact for polynomials.

With values of size F on the stencil, rounding causes an error of at most 2.1 eps F / s in a first derivative and of 7
eps F / s^2 in a second one (the sums of the moduli of the weights). Truncation causes s^8/630 of the ninth and
s^8/3150 of the tenth derivative along the direction. For a function of size 1 that is analytic in the unit disc
around x in this direction, these are at most 576 s^8 = 8e-15 and 1152 s^8 = 4e-12, less than rounding: 6e-14 and
6e-12.
"""

from collections.abc import Callable

import numpy as np

from ...arrays import Array
from ...numerics.statistics import EPS

Function = Callable[[Array], Array]

FIRST_STEP, SECOND_STEP = 2.0**-7, 2.0**-6
# Ten times the rounding errors, which leaves room for rounding within the function.
FIRST_ERROR = 20 * EPS / FIRST_STEP
SECOND_ERROR = 70 * EPS / SECOND_STEP**2

FIRST = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
SECOND = {1: 8 / 5, 2: -1 / 5, 3: 8 / 315, 4: -1 / 560}


def first(f: Function, x: Array, y: Array) -> Array:
    """Return the directional derivative Df(x) y.

    Parameters
    ----------
    f : callable, (d, P) -> (m, P)
    x : ndarray, shape (d, P)
        Point of evaluation.
    y : ndarray, shape (d, P)
        Direction; the steps are multiples of it.
    """
    s = FIRST_STEP
    return np.asarray(sum(w * (f(x + k * s * y) - f(x - k * s * y)) for k, w in FIRST.items()) / s)


def second(f: Function, x: Array, y: Array) -> Array:
    """Return the second directional derivative D^2 f(x)(y, y).

    Parameters
    ----------
    f : callable, (d, P) -> (m, P)
    x : ndarray, shape (d, P)
        Point of evaluation.
    y : ndarray, shape (d, P)
        Direction; the steps are multiples of it.
    """
    s = SECOND_STEP
    sides = sum(w * (f(x + k * s * y) + f(x - k * s * y)) for k, w in SECOND.items())
    return np.asarray((sides - 205 / 72 * f(x)) / s**2)
