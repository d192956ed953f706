"""Existence of roots of one step, for a wide range of step sizes and at distant states."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Increment, Problem, Scheme
from sdaeverify.probing import OneStep, extreme_states

# Two step sizes per decade.
SCANNED = 10.0 ** np.arange(-6.0, 3.25, 0.5)
SEED = 20170606
# Size of nonzero increments, in standard deviations.
REACH = 3.0


class RootScan(NamedTuple):
    """Outcomes of one step of H sizes from S states.

    Attributes
    ----------
    h : ndarray, shape (H,)
        Ascending.
    x : ndarray, shape (d, S)
    failed, lost : ndarray, shape (S, H)
        1 if the step found no root, or is not finite, for some increment; 0 otherwise.
    """

    h: Array
    x: Array
    failed: Array
    lost: Array


def root_scan(scheme: Scheme, view: Problem) -> RootScan:
    """Make one step of each size from each state, without noise and with an increment of three standard deviations.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form; the map can be probed, see `OneStep.why_not_probed`.

    Returns
    -------
    RootScan
    """
    step = OneStep(scheme, view)
    x = extreme_states(view, step.equation)
    noise = _directions(scheme, view, x.shape[1])
    with np.errstate(all="ignore"):
        levels = [_level(step, x, noise, float(h)) for h in SCANNED]
    failed, lost = (np.stack(parts, axis=-1) for parts in zip(*levels, strict=True))
    return RootScan(SCANNED, x, failed, lost)


def _directions(scheme: Scheme, view: Problem, states: int) -> Array:
    """Return increments over sqrt(h), shape (l, 2 S): zero, and one in a random direction, for each state."""
    rng = np.random.Generator(np.random.Philox(key=SEED))
    reach = max(scheme.law.values) if scheme.law.bounded else REACH
    far = reach * rng.choice([-1.0, 1.0], size=(view.noise_dim, states))
    return np.stack([np.zeros_like(far), far], axis=-1).reshape(view.noise_dim, -1)


def _level(step: OneStep, x: Array, noise: Array, h: float) -> tuple[Array, Array]:
    t, wide = step.time, np.repeat(x, 2, axis=1)
    l, still = len(noise), np.zeros_like(noise)
    areas = np.zeros((l * (l - 1) // 2, noise.shape[1]))
    increment = Increment(np.sqrt(h) * noise, still if "H" in step.scheme.noise else None, K=still, A=areas)
    result = step.make(wide, t, h, increment)
    failed = np.zeros(wide.shape[1], dtype=bool) if result.failed is None else result.failed
    state = result.state if isinstance(result.state, tuple) else (result.state,)
    return _any_of_pairs(failed), _any_of_pairs(~np.isfinite(np.concatenate(state)).all(axis=0))


def _any_of_pairs(bad: Array) -> Array:
    return bad.reshape(-1, 2).any(axis=1).astype(float)
