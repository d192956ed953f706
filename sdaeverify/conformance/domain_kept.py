"""Whether the steps of a scheme stay in the states that it says it is for."""

import numpy as np

from ..contracts.scheme import Scheme
from ..forms import Problem
from ..probe.local.step_law import state_words
from ..probe.step.nodes import SEED
from ..probe.step.one_step import OneStep
from ..probe.step.states import reached_states

# Steps of the horizon, coarse and fine, and paths from each state: the normal increments of so many are up to 4.
STEPS, PATHS = (8, 64), 64
STATES = 64


def domain_violation(scheme: Scheme, view: Problem) -> str:
    """Return from which state a step of a scheme with a domain leaves it, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form; its own domain lies in that of the scheme.
    """
    step = OneStep(scheme, view)
    if scheme.domain is None or step.why_not_comparable() or step.untold(scheme.start(view, 1, view.horizon)):
        return ""
    x = reached_states(view, step.equation).points
    x = np.tile(x[:, :: max(1, x.shape[1] // STATES)], PATHS)
    rng = np.random.Generator(np.random.Philox(key=SEED + 20))
    for h in (view.horizon / count for count in STEPS):
        noise = scheme.law.increment(view.drawn(rng, h, x.shape[1]), h)
        left = ~scheme.domain.contains(step(x, step.time, h, noise))
        if left.any():
            where = f"on {left.sum()} of {left.size} paths, from {state_words(x[:, left.argmax()])} with h = {h:.2g}"
            return f"a step leaves the states with {scheme.domain} that the scheme is for, {where}"
    return ""
