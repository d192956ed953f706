"""Derivatives of analytic functions by complex steps: exact to rounding, without a step size to choose.

Functions take and return arrays with paths last, ``(n, P) -> (..., P)``, and must be analytic: abs, conj,
comparisons and assignment into real arrays break them (`is_analytic` checks this).
"""

import warnings
from collections.abc import Callable

import numpy as np

from ..arrays import Array
from .digits import ORDINARY, unit_of

Function = Callable[[Array], Array]

EPS = float(np.finfo(float).eps)
# The imaginary part of f(x + i s y) gives the derivative without a subtraction, so that s may be arbitrarily small.
TINY = 1e-100
# Second derivatives do subtract first-order parts: rounding eps/s and truncation s^4 balance near 1e-3. The step s is
# in units of x, for any size of the direction, and relative to the size of x if that is far from one.
SECOND = 1e-3
# Factor of a second step size, which estimates the error; a relative error that is small enough.
OTHER, CLOSE = 1.25, 1e-6
# Largest part of a change that may be rounding if a difference is to estimate a derivative.
SEEN = 1e-3
# Lengths over which a function may change at x = 0, where the argument gives no scale.
SHORTER = (1e-3, 1e-6, 1e-9)
# Complex numbers that are differentiated in one call: with more, memory traffic costs what fewer calls save.
TOGETHER = 2**13
DIAGONAL = SECOND * np.exp(0.25j * np.pi)


def directional(f: Function, x: Array, y: Array) -> Array:
    """Return Df(x) y.

    Parameters
    ----------
    f : callable, (n, P) -> (..., P)
        Analytic: it is evaluated at complex x.
    x : ndarray, shape (n, P)
        Point of evaluation.
    y : ndarray, shape (n, P)
        Direction.

    Returns
    -------
    ndarray, shape (..., P)
    """
    return np.imag(f(_moved(x, y))) / TINY


def jacobian(f: Function, x: Array) -> Array:
    """Return Df(x), shape (m, n, P), for f : (n, P) -> (m, P).

    A tiny imaginary part y of x is the complex step of a caller: the result is then Df(x) + i D^2 f(x)(y, .), so that
    a Jacobian taken here can be differentiated once more.
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
    """Return Df(x) like `jacobian`, in one call of f if there are few paths; f must accept any number of paths.

    Parameters
    ----------
    f : callable, ndarray of shape (n, Q) -> ndarray of shape (m, Q) or (m, 1)
    x : ndarray, shape (n, P)

    Returns
    -------
    ndarray, shape (m, n, P) or (m, n, 1)
    """
    n, P = x.shape
    # A single path may be summed in another order than one of many.
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

    If the size of x is far from one, f may change over lengths of size 1 or of the size of x. So both steps are
    tried, and the longer one is used if its error is small, or smaller than that of the shorter one.

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
    # A step that is far too long may overflow.
    with np.errstate(all="ignore"):
        (near, off_near), (far, off_far) = (_with_error(f, x, y, z, unit) for unit in (short, long))
    largest = np.abs(far).reshape(-1, far.shape[-1]).max(axis=0)
    good = np.isfinite(off_far) & (off_far <= np.maximum(off_near, CLOSE * largest))
    return np.where(good, far, near)


def _with_error(f: Function, x: Array, y: Array, z: Array, unit: Array) -> tuple[Array, Array]:
    """Return D^2 f(x)(y, z), and its error estimated from another step size and rounding."""
    found, other = (_second(f, x, y, z, part * unit) for part in (1.0, OTHER))
    rounding = EPS * np.abs(f(np.real(x))) * _size(y) * _size(z) / (SECOND * unit) ** 2
    return found, np.abs(other - found) + rounding


def _second(f: Function, x: Array, y: Array, z: Array, unit: Array | float) -> Array:
    """Return D^2 f(x)(y, z) by steps of 1e-3 times `unit`, which may differ by path."""

    def square(w: Array) -> Array:
        step = DIAGONAL * unit * w
        return np.imag(f(x + step) + f(x - step)) / (SECOND * unit) ** 2

    a, b = _size(y), _size(z)
    value: Array = 0.25 * a * b * (square(y / a + z / b) - square(y / a - z / b))
    return value


def is_analytic(f: Function, x: Array) -> bool:
    """Return whether complex steps of f agree with central differences at x and at a nearby point.

    The nearby point detects kinks: at its kink, an even function like abs has both derivatives zero.
    """
    y = np.broadcast_to(np.cos(np.arange(1.0, len(x) + 1)).reshape(-1, *(1,) * (x.ndim - 1)), x.shape)
    size = max(1.0, float(np.abs(x).max()))
    # At a length of 1, f may overflow if x has other units.
    with np.errstate(all="ignore"):
        return any(
            all(_steps_agree(f, point, size * length * y) for point in (x, x + 1e-3 * size * length * y))
            for length in lengths(x)
        )


def lengths(x: Array) -> tuple[float, ...]:
    """Return the lengths over which f may change: 1, and the unit of x if another, or `SHORTER` if x = 0."""
    size = float(np.abs(x).max(initial=0.0))
    if size == 0.0:
        return (1.0, *SHORTER)
    unit = float(unit_of(size))
    return (1.0, unit) if unit != 1.0 else (1.0,)


def matches_differences(f: Function, derivative: Array, x: Array, y: Array) -> bool:
    """Return whether a derivative Df(x) y agrees with the central difference of f.

    The difference of step s = eps^(1/3) has an error of s^2/6 of the third derivative and of eps/s of f; a wrong
    derivative has an error of its own size. Along a short direction the third derivative is taken to have the size by
    which f changes, which must exceed rounding; along other directions it is taken to have at least size 1.

    Parameters
    ----------
    f : callable, ndarray of shape (d, P) -> ndarray of shape (..., P)
    derivative : ndarray, shape (..., P)
        Df(x) y to be checked.
    x : ndarray, shape (d, P)
    y : ndarray, shape (d, P)
        Direction.
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
    # Return x + i TINY y; for real NumPy arrays without complex products.
    if not all(isinstance(part, np.ndarray) and not np.iscomplexobj(part) for part in (x, y)):
        moved: Array = x + 1j * TINY * y
        return moved
    z = np.empty(np.broadcast_shapes(x.shape, y.shape), dtype=complex)
    z.real, z.imag = x, TINY * y
    return z


def _partial(f: Function, x: Array, i: int) -> Array:
    # Return `directional` along the i-th unit vector, without multiplying by zeros.
    z = x.astype(complex)
    z.imag[i] = TINY
    return np.imag(f(z)) / TINY


def _size(y: Array) -> Array:
    # Return the largest component of each path's direction, 1 if all vanish; shape (P,).
    largest = np.abs(y).max(axis=0)
    return np.where(largest > 0.0, largest, 1.0)
