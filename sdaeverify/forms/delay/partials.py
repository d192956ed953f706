"""Derivatives of a function of (t, x, v, y) in x, v and y, by complex step."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...numerics.derivatives import jacobian


class Partials(NamedTuple):
    """The derivatives of a function with n components.

    Attributes
    ----------
    x, v : ndarray, shape (n, d, P)
    y : ndarray, shape (n, q, P)
    """

    x: Array
    v: Array
    y: Array


def partials(f: Callable[[float, Array, Array, Array], Array], t: float, x: Array, v: Array, y: Array) -> Partials:
    """Return the derivatives of f at (t, x, v, y), by complex steps.

    Parameters
    ----------
    f : callable, (t, x, v, y) -> ndarray, shape (n, P)
    t : float
    x, v : ndarray, shape (d, P)
        The solution at t, and one delay before t.
    y : ndarray, shape (q, P)
        Algebraic components; q may be 0.

    Returns
    -------
    Partials
    """
    in_x, in_v = jacobian(lambda z: f(t, z, v, y), x), jacobian(lambda z: f(t, x, z, y), v)
    # Without y the derivative is an empty matrix.
    in_y = jacobian(lambda z: f(t, x, v, z), y) if len(y) else np.zeros((len(in_x), 0, x.shape[-1]))
    return Partials(in_x, in_v, in_y)
