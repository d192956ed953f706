"""Whether a step hears its noise, and keeps none of it."""

from typing import Any

import numpy as np

from ..arrays import Array
from ..contracts.scheme import flatten
from ..forms import DelaySDAE
from ..noise.brownian import Increment
from ..probe.step.states import WHEN
from .trial import Trial


def hears_its_noise(trial: Trial) -> str:
    """Make the step with noise of the other sign and of half the size.

    A linear step may by chance be even in dW, or constant on one side of 0, at one step size; a step that fails may
    stay where it was, and where the equation has no noise, nothing moves. A step that accepts or rejects may stay on
    some paths, but not on all of them.
    """
    steps = [trial.first, *(trial.step(trial.state, _scaled(trial.noise, s)) for s in (-1.0, 0.5))]
    new, opposite, half = (flatten(made.state) for made in steps)
    changed = np.any((new != opposite) | (new != half), axis=0)
    failed = np.all([np.zeros(trial.paths, dtype=bool) if made.failed is None else made.failed for made in steps], 0)
    listening = _kicked(trial) & ~failed
    deaf = int(np.count_nonzero(listening & ~changed))
    if trial.scheme.jumps and deaf < np.count_nonzero(listening):
        return ""
    return f"noise of another sign or size changes nothing on {deaf} of {trial.paths} paths" if deaf else ""


def keeps_no_noise(trial: Trial) -> str:
    """Look for memory that the new state shares with the noise."""
    arrays = trial.first.state if isinstance(trial.first.state, tuple) else (trial.first.state,)
    noise = [part for part in trial.noise if part is not None]
    shared = any(np.may_share_memory(a, b) for a in arrays for b in noise)
    return "the new state is a view of the noise, into which the next noise is drawn" if shared else ""


def _scaled(noise: Increment, s: float) -> Increment:
    return noise._replace(dW=s * noise.dW, H=None if noise.H is None else s * noise.H)


def _kicked(trial: Trial) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Tell on which paths the equation's noise moves the state."""
    kick = _kick(trial)
    return np.ones(trial.paths, dtype=bool) if kick is None else np.any(kick != 0.0, axis=0)


def _kick(trial: Trial) -> Array | None:
    parts, t, view = trial.scheme.parts(trial.view, trial.state), WHEN * trial.view.horizon, trial.view
    if isinstance(view, DelaySDAE):
        lagged = parts["x"] if trial.noise.lagged is None else trial.noise.lagged
        y = parts.get("y", parts["x"][:0])
        return view.diffused(t, parts["x"], lagged, y, trial.noise.dW)
    ito = view.ito()
    if ito is None or not set(ito.names or ("x",)) <= set(parts):
        return None
    return np.asarray(ito.diffused(t, np.concatenate([parts[name] for name in ito.names or ("x",)]), trial.noise.dW))
