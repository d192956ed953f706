"""The times at which a one-step map is probed: one, and others at which it goes elsewhere.

Where neither equation nor scheme depend on time, one time is as good as any. A step that is wrong from some time on,
or right at one time only, is not seen there; that it does not go to the same place at another time is.
"""

import numpy as np

from ..arrays import Array
from ..noise import Increment
from .nodes import SEED
from .one_step import OneStep
from .states import WHEN

# As parts of the horizon; the last one is late enough for what sets in near the end.
ELSEWHEN = np.arange(1.0, 16.0, 2.0) / 16.0
# Of the horizon, or of the unit of time where that is shorter.
H = 2.0**-6
# A step that depends on time moves by more than this part of the states.
SAME = 1e-9


def times(step: OneStep, x: Array) -> tuple[float, ...]:
    """Return the times at which a step is probed.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S)
        States of the cloud.

    Returns
    -------
    tuple of float
        0.2 of the horizon; then the first and the last of eight times at which the same noise leads elsewhere.
    """
    horizon = step.view.horizon
    h = H * step.view.time_unit
    noise = _noise(step, h, x.shape[1])
    with np.errstate(all="ignore"):
        there = [step(x, when * horizon, h, noise) for when in (WHEN, *ELSEWHEN)]
    size = SAME * np.abs(there[0]).max(where=np.isfinite(there[0]), initial=0.0)
    moved = [not np.allclose(new, there[0], rtol=SAME, atol=size, equal_nan=True) for new in there[1:]]
    found = ELSEWHEN[moved]
    return tuple(horizon * when for when in dict.fromkeys((WHEN, *found[:1], *found[-1:])))


def _noise(step: OneStep, h: float, paths: int) -> Increment:
    rng = np.random.Generator(np.random.Philox(key=SEED + 3))
    dW, areas = np.sqrt(h) * rng.standard_normal((2, step.view.noise_dim, paths))
    drawn = Increment(dW, areas / np.sqrt(12.0) if "H" in step.view.noise else None)
    return step.scheme.law.increment(drawn, h)
