"""Problems in other units of state and time."""

import numpy as np

from sdaeverify import SDE, Array, Problem


def in_units(problem: Problem, scale: float = 1.0, shift: float = 0.0, time: float = 1.0) -> SDE:
    """Return the equation of y = scale x + shift in the time s = time t."""
    old = problem.ito()
    assert old is not None

    def drift(s: float, y: Array) -> Array:
        return scale / time * old.drift(s / time, (y - shift) / scale)

    def diffusion(s: float, y: Array) -> Array:
        return scale / np.sqrt(time) * old.diffusion(s / time, (y - shift) / scale)

    start, horizon = scale * old.initial(1)[:, 0] + shift, time * old.horizon
    return SDE(drift=drift, diffusion=diffusion, start=start, noise_dim=old.noise_dim, horizon=horizon, source="test")
