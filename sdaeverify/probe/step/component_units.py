"""Units of components that are far smaller than the state, so that errors are compared with their own size."""

import numpy as np

from ...arrays import Array
from ...numerics.statistics import EPS
from .nodes import SEED
from .one_step import OneStep

# Errors of a component smaller than the state by this factor would pass for rounding of the state. Below the second
# factor a component consists of rounding errors of the others.
# Rounding: of a component with 2^-12 of the state, rounding of the state hides 12 of 52 bits; 64 operations err by at
# most 64 eps of their sizes (Higham 2002, Lemma 3.1).
FAR, LEAST = 2.0**-12, 64.0 * EPS
# Relative perturbation of the state, to measure how a step carries relative errors of all components into each.
# Rounding: a difference errs by eps/2^-20 = 2^-32, and by 2^-20 of a second derivative.
NUDGE = 2.0**-20


def component_units(step: OneStep, x: Array, h: float) -> Array:
    """Return the units in which errors of components are compared with the size of the state, shape (C,).

    A step rounds component i by EPS s_i, where s_i is the largest of |x_i|, |Phi_i| and sum_j |dPhi_i/dx_j| |x_j|,
    for which two directions are tried. The unit is 1, except for components with s_i far below the largest s_j.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S)
        States.
    h : float
        Step size.
    """
    sizes = np.abs(x).max(axis=1)
    if (sizes >= FAR * sizes.max()).all():
        return np.ones(len(step.names))
    t, rng = step.time, np.random.Generator(np.random.Philox(key=SEED + 13))
    noise = step.scheme.law.increment(step.view.drawn(rng, h, x.shape[1]), h)
    alternating = np.where(np.arange(len(x)) % 2, -1.0, 1.0)[:, None]
    pushed = x, x * (1.0 + NUDGE), x * (1.0 + NUDGE * alternating)
    with np.errstate(all="ignore"):
        there, *others = (step(states, t, h, noise) for states in pushed)
        every = np.stack([x, there, *((other - there) / NUDGE for other in others)])
    sizes = np.nan_to_num(np.abs(every), nan=np.inf).max(axis=(0, 2))
    share = sizes / sizes.max() if np.isfinite(sizes).all() else np.ones(len(x))
    own = (share < FAR) & (share > LEAST)
    unit = np.exp2(np.floor(np.log2(np.where(own, share, 1.0))))
    return np.array([unit[rows].max() for rows in step.names.values()])
