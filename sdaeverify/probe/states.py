"""The cloud of states at which a one-step map is probed."""

import numpy as np

from ..arrays import Array
from ..forms import SDE, Problem
from .nodes import SEED

# Points of the cloud beside the initial state, in each of its two parts.
PILOT, SCATTERED = 6, 6
PILOT_H = 2.0**-6
NEWTON_STEPS = 50


def cloud(view: Problem, ito: SDE) -> Array:
    """Return the initial state, points of a pilot trajectory, and points scattered around them.

    The pilot is Euler-Maruyama with h = 2^-6, at least 64 steps, at six times on six paths. The scattered points
    are the pilot's, moved at random by as much as it has moved; on a constrained problem all are brought onto the
    manifold, with velocities projected onto the tangent space.

    Parameters
    ----------
    view : Problem
        With its constraints, if it has some.
    ito : SDE
        The Ito equation of its comparable components.

    Returns
    -------
    ndarray, shape (d, 13)
    """
    rng = np.random.Generator(np.random.Philox(key=SEED + 1))
    start = ito.initial(1)
    pilot = _pilot(ito, rng)
    spread = np.abs(pilot - start).max(axis=1, keepdims=True)
    scattered = pilot + np.where(spread > 0.0, spread, 1.0) * rng.uniform(-1.0, 1.0, (len(start), SCATTERED))
    moved = np.concatenate([pilot, scattered], axis=1)
    return np.concatenate([start, view.admissible(moved) if view.has_constraints else moved], axis=1)


def _pilot(ito: SDE, rng: np.random.Generator) -> Array:
    steps = max(64, int(np.ceil(ito.horizon / PILOT_H)))
    h, x = ito.horizon / steps, ito.initial(PILOT)
    kept = np.linspace(steps / PILOT, steps, PILOT).astype(int)
    points = np.empty_like(x)
    for step in range(steps):
        dW = np.sqrt(h) * rng.standard_normal((ito.noise_dim, PILOT))
        B = np.broadcast_to(ito.diffusion(step * h, x), (len(x), len(dW), PILOT))
        x = x + h * ito.drift(step * h, x) + np.einsum("dlp,lp->dp", B, dW)
        done = kept == step + 1
        points[:, done] = x[:, done]
    return np.where(np.isfinite(points), points, ito.initial(PILOT))
