"""Derivatives of analytic functions by complex steps: exact to rounding, no step size to choose.

Functions take and return arrays with paths last, ``(n, P) -> (..., P)``, and must be analytic: abs, conj,
comparisons and assignment into real arrays break them (`is_analytic` tells).
"""

import warnings
from collections.abc import Callable

import numpy as np

from ..arrays import Array
from .digits import ORDINARY, unit_of

Function = Callable[[Array], Array]

EPS = float(np.finfo(float).eps)
# f(x + i s y) has its derivative in the imaginary part, without subtraction: s may be as small as one likes.
TINY = 1e-100
# Second derivatives do subtract first-order parts: rounding eps/s and truncation s^4 balance near 1e-3.
# The step is s in units of x, whatever the size of the direction, and in parts of x where x is far from order one.
SECOND = 1e-3
# Another step size, which tells an error; a relative error that is small enough.
OTHER, CLOSE = 1.25, 1e-6
# Part of a change that rounding may be where a difference tells a derivative.
SEEN = 1e-3
# Lengths over which a function may change where its argument says nothing of them.
SHORTER = (1e-3, 1e-6, 1e-9)
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

    Of x far from order one it is not known whether f changes over lengths of size 1 or of the size of x. So both
    steps are made, and the longer one counts where its error is small, or smaller than that of the other.

    Parameters
    ----------
    f : callable, ndarray of shape (d, P) -> ndarray of shape (..., P)
        Analytic.
    x : ndarray, shape (d, P)
    y, z : ndarray, shape (d, P)
        Directions.
    """
    unit = unit_of(_size(np.real(x)))
    if np.all(unit == 1.0):
        return _second(f, x, y, z, 1.0)
    short, long = np.minimum(unit, 1.0), np.maximum(unit, 1.0)
    # A step that is far too long may lead beyond the numbers.
    with np.errstate(all="ignore"):
        (near, off_near), (far, off_far) = (_with_error(f, x, y, z, unit) for unit in (short, long))
    largest = np.abs(far).reshape(-1, far.shape[-1]).max(axis=0)
    good = np.isfinite(off_far) & (off_far <= np.maximum(off_near, CLOSE * largest))
    return np.where(good, far, near)


def _with_error(f: Function, x: Array, y: Array, z: Array, unit: Array) -> tuple[Array, Array]:
    """Return D^2 f(x)(y, z), and what another step size and rounding say of its error."""
    found, other = (_second(f, x, y, z, part * unit) for part in (1.0, OTHER))
    rounding = EPS * np.abs(f(np.real(x))) * _size(y) * _size(z) / (SECOND * unit) ** 2
    return found, np.abs(other - found) + rounding


def _second(f: Function, x: Array, y: Array, z: Array, unit: Array | float) -> Array:
    """Return D^2 f(x)(y, z) by steps of 1e-3 in some units, one of each path."""

    def square(w: Array) -> Array:
        step = DIAGONAL * unit * w
        return np.imag(f(x + step) + f(x - step)) / (SECOND * unit) ** 2

    a, b = _size(y), _size(z)
    value: Array = 0.25 * a * b * (square(y / a + z / b) - square(y / a - z / b))
    return value


def is_analytic(f: Function, x: Array) -> bool:
    """Tell whether complex steps of f agree with central differences at x and at a point nearby.

    The second point is for kinks: an even function like abs has both derivatives zero on its kink.
    """
    y = np.broadcast_to(np.cos(np.arange(1.0, len(x) + 1)).reshape(-1, *(1,) * (x.ndim - 1)), x.shape)
    size = max(1.0, float(np.abs(x).max()))
    # In other units f may be far beyond the numbers at a length of 1.
    with np.errstate(all="ignore"):
        return any(
            all(_steps_agree(f, point, size * length * y) for point in (x, x + 1e-3 * size * length * y))
            for length in lengths(x)
        )


def lengths(x: Array) -> tuple[float, ...]:
    """Return over which lengths a function of x may change: 1, the unit of x where far smaller, shorter ones if 0."""
    size = float(np.abs(x).max(initial=0.0))
    if size == 0.0:
        return (1.0, *SHORTER)
    unit = float(unit_of(size))
    return (1.0, unit) if unit < 1.0 else (1.0,)


def matches_differences(f: Function, derivative: Array, x: Array, y: Array) -> bool:
    """Tell whether a derivative Df(x) y agrees with the central difference of f.

    The difference of step s = eps^(1/3) is off by s^2/6 of the third derivative and by eps/s of f; a wrong
    derivative is off by as much as the derivative itself. Along a short direction the third derivative has the size
    by which f changes, which has to be more than rounding; along others at least the size 1.

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
    short, rounding = np.abs(y).max() < 2.0**-ORDINARY, 10 * EPS / step * np.max(np.abs(f(x)))
    size = float(np.max(np.abs([f(x + y) - f(x), f(x - y) - f(x)]))) if short else 1.0
    tolerance = 1e-6 * (size + np.max(np.abs(central))) + rounding
    told = not short or rounding < SEEN * size
    return bool(told and np.all(np.abs(derivative - central) < tolerance))


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
