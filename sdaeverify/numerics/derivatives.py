"""Derivatives of analytic functions by complex steps: exact to rounding, no step size to choose.

Functions take and return arrays with paths last, ``(n, P) -> (..., P)``, and must be analytic: abs, conj,
comparisons and assignment into real arrays break them (`is_analytic` tells).
"""

import warnings
from collections.abc import Callable

import numpy as np

from ..arrays import Array

Function = Callable[[Array], Array]

EPS = float(np.finfo(float).eps)
# f(x + i s y) has its derivative in the imaginary part, without subtraction: s may be as small as one likes.
TINY = 1e-100
# Second derivatives do subtract first-order parts: rounding eps/s and truncation s^4 balance near 1e-3.
# The step is s in units of x, whatever the size of the direction: x should be of order one.
SECOND = 1e-3
# Complex numbers that are differentiated side by side: with more of them, what is saved in calls is lost in memory.
TOGETHER = 2**13
DIAGONAL = SECOND * np.exp(0.25j * np.pi)


def directional(f: Function, x: Array, y: Array) -> Array:
    """Return Df(x) y.

    Parameters
    ----------
    f : callable, (n, P) -> (..., P)
        Analytic: it is evaluated at complex x.
    x : ndarray, shape (n, P)
        Where.
    y : ndarray, shape (n, P)
        Direction.

    Returns
    -------
    ndarray, shape (..., P)
    """
    return np.imag(f(_moved(x, y))) / TINY


def jacobian(f: Function, x: Array) -> Array:
    """Return Df(x), shape (m, n, P), for f : (n, P) -> (m, P).

    An infinitesimal imaginary part y of x is a complex step of the caller's: the result is then
    Df(x) + i D^2 f(x)(y, .), so that a Jacobian taken here can be differentiated once more.
    """
    point = np.real(x)
    columns = [_partial(f, point, i) for i in range(len(x))]
    first = np.empty((len(columns[0]), len(x), *columns[0].shape[1:]))
    for i, column in enumerate(columns):
        first[:, i] = column
    if not np.iscomplexobj(x):
        return first
    step = np.imag(x)
    units = np.eye(len(x)).reshape(len(x), len(x), *(1,) * (x.ndim - 1))
    mixed = [second_directional(f, point, step, np.broadcast_to(unit, x.shape)) for unit in units]
    return first + 1j * np.stack(mixed, axis=1)


def jacobian_at_once(f: Function, x: Array) -> Array:
    """Return Df(x) like `jacobian`, for f that takes any number of paths: as one call where paths are few.

    Parameters
    ----------
    f : callable, ndarray of shape (n, Q) -> ndarray of shape (m, Q) or (m, 1)
    x : ndarray, shape (n, P)

    Returns
    -------
    ndarray, shape (m, n, P) or (m, n, 1)
    """
    n, P = x.shape
    # A path alone may be summed in another order than one of many.
    if n == 1 or P == 1 or n * n * P > TOGETHER or np.iscomplexobj(x):
        return jacobian(f, x)
    z = np.zeros((n, n, P), dtype=complex)
    z.real = x[:, None]
    z.imag[np.arange(n), np.arange(n)] = TINY
    value = np.imag(f(z.reshape(n, n * P))) / TINY
    if value.shape[-1] == 1:
        return np.repeat(value[:, None], n, axis=1)
    return value.reshape(-1, n, P)


def second_directional(f: Function, x: Array, y: Array, z: Array) -> Array:
    """Return D^2 f(x)(y, z), shape (..., P).

    With s = 1e-3 e^{i pi/4}, directions y and z scaled to size 1, and w = y + z or y - z,
    Im[f(x + s w) + f(x - s w)] = 1e-6 D^2 f(x)(w, w) + O(1e-18), and (y, z) follows by polarisation.

    Parameters
    ----------
    f : callable, ndarray of shape (d, P) -> ndarray of shape (..., P)
        Analytic.
    x : ndarray, shape (d, P)
    y, z : ndarray, shape (d, P)
        Directions.
    """

    def square(w: Array) -> Array:
        return np.imag(f(x + DIAGONAL * w) + f(x - DIAGONAL * w)) / SECOND**2

    a, b = _size(y), _size(z)
    value: Array = 0.25 * a * b * (square(y / a + z / b) - square(y / a - z / b))
    return value


def is_analytic(f: Function, x: Array) -> bool:
    """Tell whether complex steps of f agree with central differences at x and at a point nearby.

    The second point is for kinks: an even function like abs has both derivatives zero on its kink.
    """
    y = np.broadcast_to(np.cos(np.arange(1.0, len(x) + 1)).reshape(-1, *(1,) * (x.ndim - 1)), x.shape)
    size = max(1.0, float(np.abs(x).max()))
    return all(_steps_agree(f, point, size * y) for point in (x, x + 1e-3 * size * y))


def matches_differences(f: Function, derivative: Array, x: Array, y: Array) -> bool:
    """Tell whether a derivative Df(x) y agrees with the central difference of f.

    The difference of step s = eps^(1/3) is off by s^2/6 of the third derivative and by eps/s of f; a wrong
    derivative is off by as much as the derivative itself.

    Parameters
    ----------
    f : callable, ndarray of shape (d, P) -> ndarray of shape (..., P)
    derivative : ndarray, shape (..., P)
        Df(x) y as it is given.
    x : ndarray, shape (d, P)
    y : ndarray, shape (d, P)
        The direction.
    """
    step = EPS ** (1 / 3)
    central = (f(x + step * y) - f(x - step * y)) / (2 * step)
    tolerance = 1e-6 * (1.0 + np.max(np.abs(central))) + 10 * EPS / step * np.max(np.abs(f(x)))
    return bool(np.all(np.abs(derivative - central) < tolerance))


def _steps_agree(f: Function, x: Array, y: Array) -> bool:
    with warnings.catch_warnings():
        warnings.simplefilter("error", np.exceptions.ComplexWarning)
        try:
            exact = directional(f, x, y)
        except (TypeError, np.exceptions.ComplexWarning):
            return False
    return matches_differences(f, exact, x, y)


def _moved(x: Array, y: Array) -> Array:
    # x + i TINY y, without the products of complex numbers where both are real arrays, and of NumPy.
    if not all(isinstance(part, np.ndarray) and not np.iscomplexobj(part) for part in (x, y)):
        moved: Array = x + 1j * TINY * y
        return moved
    z = np.empty(np.broadcast_shapes(x.shape, y.shape), dtype=complex)
    z.real, z.imag = x, TINY * y
    return z


def _partial(f: Function, x: Array, i: int) -> Array:
    # What `directional` returns along a unit vector, without the products with zeros.
    z = x.astype(complex)
    z.imag[i] = TINY
    return np.imag(f(z)) / TINY


def _size(y: Array) -> Array:
    # Largest component of each path's direction, 1 where all of them vanish; shape (P,).
    largest = np.abs(y).max(axis=0)
    return np.where(largest > 0.0, largest, 1.0)
