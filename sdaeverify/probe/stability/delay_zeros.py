"""How many eigenvalues of a recursion y_{n+1} = sum_i A_i y_{n-i} lie outside a circle: the argument principle.

They are the z with det(Id - sum_i A_i z^-(i+1)) = 0, a polynomial D in 1/z with D = 1 at infinity, so their number is
that of the turns of D about 0 on the circle. On an arc of length a on which |D''| <= L, D is within L a^2/8 of the
chord between the values at its ends; if 0 is farther from the chord, D turns by the principal angle between them.
Arcs are halved until all are so short: the number is certain, rounding being added to the right side.
"""

import numpy as np

from ...arrays import Array
from ..linear.delay_step import Lagged

EPS = float(np.finfo(float).eps)
ARCS, ROUNDS, MOST_ARCS = 64, 60, 1 << 18


def outside(recursion: Lagged, radius: float) -> int | None:
    """Return the number of eigenvalues with |z| > radius, with multiplicities.

    Parameters
    ----------
    recursion : Lagged
    radius : float
        Positive.

    Returns
    -------
    int or None
        None if an eigenvalue is too close to the circle for the arithmetic to tell.
    """
    powers = recursion.lags + 1
    scaled = recursion.maps[0] * radius ** -powers[:, None, None].astype(float)
    with np.errstate(invalid="ignore"):
        curvature, rounding = _bounds(powers, scaled)
    if not np.isfinite(curvature):
        return None
    # D is conjugate at conjugate places: the lower half turns as much as the upper one.
    ends = np.linspace(0.0, np.pi, ARCS + 1)
    values = _determinant(powers, scaled, ends)
    a, b, at_a, at_b = ends[:-1], ends[1:], values[:-1], values[1:]
    turned = 0.0
    for _ in range(ROUNDS):
        distance = _from_zero(at_a, at_b)
        short = distance > 0.125 * curvature * (b - a) ** 2 + rounding
        turned += float(np.angle(at_b[short] / at_a[short]).sum())
        a, b, at_a, at_b = a[~short], b[~short], at_a[~short], at_b[~short]
        if len(a) == 0:
            return -round(turned / np.pi)
        if len(a) > MOST_ARCS or np.minimum(np.abs(at_a), np.abs(at_b)).min() <= rounding:
            return None
        middle = 0.5 * (a + b)
        at_middle = _determinant(powers, scaled, middle)
        a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
        at_a, at_b = np.concatenate([at_a, at_middle]), np.concatenate([at_middle, at_b])
    return None


def _determinant(powers: Array, scaled: Array, angles: Array) -> Array:
    turns = np.exp(-1j * angles[:, None] * powers)
    return np.asarray(np.linalg.det(np.eye(scaled.shape[-1]) - np.tensordot(turns, scaled, axes=1)))


def _from_zero(first: Array, last: Array) -> Array:
    # The distance of 0 from the segment between two complex numbers.
    chord = last - first
    length = np.maximum(np.abs(chord) ** 2, np.finfo(float).tiny)
    part = np.clip(-(np.conj(chord) * first).real / length, 0.0, 1.0)
    return np.asarray(np.abs(first + part * chord))


def _bounds(powers: Array, scaled: Array) -> tuple[float, float]:
    # A determinant is linear in every column, and at most the product of their norms (Hadamard).
    norms = np.linalg.norm(scaled, axis=1)
    columns = 1.0 + norms.sum(axis=0)
    product = float(columns.prod())
    slope, bend = float((powers @ norms / columns).sum()), float((powers**2 @ norms / columns).sum())
    # Values are off by their rounding, and by that of angles up to pi.
    return product * (bend + slope**2), 2.0 * EPS * product * (16.0 + 2.0 * np.pi * slope)
