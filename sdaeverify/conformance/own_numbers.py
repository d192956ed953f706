"""Detect steps that draw their own random numbers: paths with identical arguments then give different results."""

import numpy as np

from ..arrays import Array
from ..contracts.scheme import Scheme, flatten
from ..errors import FAULTS
from ..forms import Problem
from ..probe.step.states import WHEN
from .batches import take_paths
from .trial import Trial

# Number of identical paths, steps to the horizon, and the smallest difference relative to the state that is not
# rounding.
ALIKE, STEPS, APART = 2, 64, 1e-9
OWN_NUMBERS = (
    "a step draws random numbers of its own, so that no two runs are on the same noise; have it take them from "
    "noise.dW, and from noise.H or noise.uniform(h) for further ones"
)


def draws_own_numbers(scheme: Scheme, view: Problem) -> str:
    """Return that a step draws random numbers itself, and the remedy, or an empty string.

    Two paths with the same state and noise differ, and so do two calls with the same arguments. A step that counts
    its calls, or remembers arguments, gives identical paths the same result.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    try:
        with np.errstate(all="ignore"):
            return OWN_NUMBERS if _goes_apart(scheme, view) else ""
    except FAULTS:
        # Errors of a step are reported by other checks.
        return ""


def _goes_apart(scheme: Scheme, view: Problem) -> bool:
    h = view.horizon / STEPS
    trial = Trial(scheme, view, h, None, 1, scheme.start(view, 1, h))
    same = np.zeros(ALIKE, dtype=int)
    state, noise = take_paths(trial.state, same), take_paths(trial.noise, same)
    step = scheme.prepare(view, h)
    first = flatten(step(state, WHEN * view.horizon, noise).state)
    if not _apart(first[:, 0], first[:, 1]):
        return False
    again = flatten(step(state, WHEN * view.horizon, noise).state)
    return _apart(first[:, 0], again[:, 0])


def _apart(a: Array, b: Array) -> bool:
    return bool((np.abs(a - b) > APART * (1.0 + np.abs(a).max())).any())
