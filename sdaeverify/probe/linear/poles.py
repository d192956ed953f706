"""Noise that no quadrature sees: poles of a step in its noise, and second moments that rare noise carries.

A step that divides by 1 - c z has an infinite second moment, however far out the pole is, and a quadrature that stops
at 9.5 standard deviations returns a finite number. All lines through 0 that are scanned reach out to 60.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ..step.step_noise import CUT, StepNoise

FAR = 60.0
SPACING = 0.125
# A peak is followed to a distance of SPACING / ZOOM^ROUNDS.
ZOOM, ROUNDS = 8, 8
MOST_PEAKS = 64
# |z - z*|^-p has an infinite second moment from p = 1/2 on; a peak that is none has p = 0.
EXPONENT = 0.45

# Factors (n, n, K) where the normals are x, shape (variables, K).
Factors = Callable[[Array], Array]


class FarNoise(NamedTuple):
    """What was found on lines through 0.

    Attributes
    ----------
    pole : float
        Least |z| at which a factor is infinite, in standard deviations; infinite if there is none.
    left_out : float
        Bound of what |z| > 9.5 adds to the operator P -> E A P A^T, along the lines.
    """

    pole: float
    left_out: float


def far_noise(factors: Factors, noise: StepNoise) -> FarNoise:
    """Return where a step is infinite, and how much of its mean square comes from far out.

    Parameters
    ----------
    factors : callable
        [[R, r], [0, 1]] at given normals.
    noise : StepNoise

    Returns
    -------
    FarNoise
    """
    z = np.arange(-FAR, FAR + SPACING, SPACING)
    directions = noise.directions()
    lines = _sizes(factors, directions[:, :, None] * z)
    line, place = np.nonzero((lines[:, 1:-1] >= lines[:, :-2]) & (lines[:, 1:-1] > lines[:, 2:]))
    nearby = np.maximum(lines[line, place], lines[line, place + 2])
    sharpest = np.argsort(nearby / lines[line, place + 1], kind="stable")[:MOST_PEAKS]
    line, centre, nearby = line[sharpest], z[place + 1][sharpest], nearby[sharpest]
    exponent = _exponents(factors, directions[:, line], centre, nearby)
    pole = float(np.min(np.abs(centre), initial=np.inf, where=exponent > EXPONENT))
    return FarNoise(pole, np.inf if pole < np.inf else _left_out(lines, z))


def _sizes(factors: Factors, x: Array) -> Array:
    # A bound of the norm of [R, r] where the normals are x, shape (n, ...) -> (...).
    A = factors(x.reshape(len(x), -1))[:-1]
    sizes = len(A) * np.abs(A).max(axis=(0, 1)).reshape(x.shape[1:])
    return np.where(np.isnan(sizes), np.inf, sizes)


def _exponents(factors: Factors, directions: Array, centre: Array, nearby: Array) -> Array:
    """Return p of peaks like |z - z*|^-p, from how much they rise when the distance to them shrinks."""
    if not len(centre):
        return centre
    width, sizes = SPACING, nearby
    for _ in range(ROUNDS):
        places = centre[:, None] + width * np.linspace(-1.0, 1.0, 2 * ZOOM + 1)
        values = _sizes(factors, directions[:, :, None] * places)
        best = values.argmax(axis=1)
        centre, sizes = places[np.arange(len(places)), best], values.max(axis=1)
        width /= ZOOM
    return np.asarray(np.log(sizes / nearby) / np.log(SPACING / width))


def _left_out(lines: Array, z: Array) -> float:
    # |A P A^T| <= |A|^2 |P|, integrated over the far ends of a line.
    far = np.abs(z) > CUT
    density = np.exp(2.0 * np.log(lines[:, far]) - 0.5 * z[far] ** 2) / np.sqrt(2.0 * np.pi)
    return float(np.max(density.sum(axis=1)) * SPACING)
