"""Test of linear growth of coefficients, from their values along rays."""

from typing import Any

import numpy as np

from ...arrays import Array
from ...errors import FAULTS
from ...numerics.linalg import norm
from ..domain import outside

SEED = 20260613
# Radii of points on a ray, in units of the size of the start; rays per kind; most kinds of a single component.
RADII = 10.0 ** np.arange(0.0, 13.0)
RAYS, SINGLE = 4, 12
# x log x has the power 1.05 between 10^6 and 10^12; moments stay finite for it.
POWER = 1.1
# Time of evaluation, in horizons: at 0 some coefficients vanish.
WHEN = 0.2


def grows_linearly(equation: Any) -> bool:
    """Return whether drift and diffusion of an equation grow at most linearly along rays.

    Rays move all components, the named ones alone, and single ones alone: v^2/r grows linearly if v and r are large.

    Parameters
    ----------
    equation : Equation
    """
    x = _rays(equation)
    try:
        with np.errstate(all="ignore"):
            f = np.broadcast_to(equation.drift(WHEN * equation.horizon, x), x.shape)
            B = equation.diffusion(WHEN * equation.horizon, x)
            sizes = norm(f), np.broadcast_to(norm(B.reshape(-1, B.shape[-1])), x.shape[1:])
            # The growth outside a domain is irrelevant.
            known = ~outside(equation, x)
            inside = [np.where(known, size, np.nan) for size in sizes]
            return all(_power(size.reshape(-1, RAYS, len(RADII))) < POWER for size in inside)
    except FAULTS:
        # Coefficients that cannot be evaluated far out are not known to grow linearly.
        return False


def _rays(equation: Any) -> Array:
    """Return points along the rays, shape (d, kinds * RAYS * len(RADII))."""
    rng = np.random.Generator(np.random.Philox(key=SEED))
    start, d = equation.initial(1)[:, 0], equation.dimension
    unit = np.abs(start).max() or 1.0
    moved = [np.ones(d), *(np.isin(np.arange(d), np.arange(d)[rows]) for rows in (equation.names or {}).values())]
    moved += list(np.eye(d)[rng.permutation(d)[:SINGLE]])
    if equation.domain is None:
        ways, base = rng.standard_normal((len(moved), RAYS, d)), start + unit * rng.uniform(-0.5, 0.5, (RAYS, d))
    else:
        # Rays away from a corner of the domain, if there is one.
        ways, base = np.array([equation.domain.draw(d, RAYS, SEED + k).T for k in range(2)])
    directions = np.array(moved)[:, None] * ways
    points = base[None, :, None] + unit * RADII[:, None] * directions[:, :, None]
    return np.ascontiguousarray(points.reshape(-1, d).T)


def _power(sizes: Array) -> float:
    """Return the largest growth exponent of sizes, shape (kinds, RAYS, R), on the outer half of the rays.

    For each kind the median over its rays is used, because coefficients may oscillate. Points beyond the first radius
    at which they are not finite are ignored.
    """
    log = np.log10(sizes)
    last = np.isfinite(sizes).cumprod(axis=-1).sum(axis=-1) - 1
    middle = (last + 1) // 2
    ends = (np.take_along_axis(log, np.maximum(at, 0)[..., None], axis=-1)[..., 0] for at in (middle, last))
    low, high = ends
    slopes = np.where(last > middle, (high - low) / np.maximum(last - middle, 1), np.nan)
    slopes = np.where(np.isfinite(slopes) & (last >= 0), slopes, np.where(np.isposinf(sizes[..., 1]), np.inf, 0.0))
    return float(np.median(slopes, axis=1).max())
