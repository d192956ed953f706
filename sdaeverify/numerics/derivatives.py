"""Derivatives of analytic functions by complex steps: exact to rounding, no step size to choose.

Functions take and return arrays with paths last, ``(n, P) -> (..., P)``, and must be analytic: abs, conj,
comparisons and assignment into real arrays break them (`is_analytic` tells).
"""

from collections.abc import Callable

import numpy as np

from ..arrays import Array

Function = Callable[[Array], Array]

# f(x + i s y) has its derivative in the imaginary part, without subtraction: s may be as small as one likes.
TINY = 1e-100
# Second derivatives do subtract first-order parts: rounding eps/s and truncation s^4 balance near 1e-3.
SECOND = 1e-3
DIAGONAL = SECOND * np.exp(0.25j * np.pi)


def directional(f: Function, x: Array, y: Array) -> Array:
    """Return Df(x) y.

    Parameters
    ----------
    f : callable, (n, P) -> (..., P)
    x, y : ndarray, shape (n, P)

    Returns
    -------
    ndarray, shape (..., P)
    """
    return np.imag(f(x + 1j * TINY * y)) / TINY


def jacobian(f: Function, x: Array) -> Array:
    """Return Df(x), shape (m, n, P), for f : (n, P) -> (m, P)."""
    units = np.eye(len(x)).reshape(len(x), len(x), *(1,) * (x.ndim - 1))
    return np.stack([directional(f, x, np.broadcast_to(unit, x.shape)) for unit in units], axis=1)


def second_directional(f: Function, x: Array, y: Array, z: Array) -> Array:
    """Return D^2 f(x)(y, z), shape (..., P).

    With s = 1e-3 e^{i pi/4} and w = y + z or y - z,
    Im[f(x + s w) + f(x - s w)] = 1e-6 D^2 f(x)(w, w) + O(1e-18), and (y, z) follows by polarisation.
    """

    def square(w: Array) -> Array:
        return np.imag(f(x + DIAGONAL * w) + f(x - DIAGONAL * w)) / SECOND**2

    return 0.25 * (square(y + z) - square(y - z))


def is_analytic(f: Function, x: Array) -> bool:
    """Tell whether complex steps of f agree with central differences at x.

    The difference of step s = eps^(1/3) is off by about 1e-10 of the function's scale; a function that is
    not analytic is off by as much as its derivative.
    """
    step = np.finfo(float).eps ** (1 / 3)
    y = np.broadcast_to(np.cos(np.arange(1.0, len(x) + 1)).reshape(-1, *(1,) * (x.ndim - 1)), x.shape)
    try:
        exact = directional(f, x, y)
    except (TypeError, np.exceptions.ComplexWarning):
        return False
    central = (f(x + step * y) - f(x - step * y)) / (2 * step)
    scale = 1.0 + np.max(np.abs(central), initial=0.0)
    return bool(np.all(np.abs(exact - central) < 1e-6 * scale))
