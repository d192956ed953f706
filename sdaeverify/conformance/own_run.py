"""States along a scheme's own run: where iterations, truncation and constraints are at work."""

from typing import Any

import numpy as np

from ..contracts.scheme import Scheme, State
from ..noise.brownian import Increment, Source, brownian_steps
from .batches import frozen

# So many steps over the horizon, at most; of more paths than that some stop together.
STEPS = 16


def stopped_states(scheme: Scheme, view: Any, paths: int) -> State:
    """Return states along a run over the horizon: the paths are stopped one after the other, where they are.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    paths : int

    Returns
    -------
    ndarray or NamedTuple of ndarray
        They cannot be written into.
    """
    steps = min(paths, STEPS)
    h, last = view.horizon / steps, np.arange(paths) * steps // paths
    state, stepper = scheme.start(view, paths, h), scheme.prepare(view, h)
    recall = view.recall(h, paths)
    for n in range(last[-1]):
        noise = scheme.law.increment(brownian(view.noise_dim, paths, h, n), h)
        new = stepper(frozen(state), n * h, noise if recall is None else recall.driven(noise)).state
        state = _chosen(last > n, new, state)
        if recall is not None:
            recall.push(scheme.parts(view, state)["x"])
    return frozen(state)


def brownian(dimension: int, paths: int, h: float, block: int) -> Increment:
    """Return the Brownian noise of one step."""
    (level,) = next(brownian_steps(Source(1, "conformance", block, paths), dimension, h, 0))
    return level.increment(0)


def _chosen(mask: np.ndarray[Any, np.dtype[np.bool_]], new: State, old: State) -> State:
    if not isinstance(new, tuple):
        return np.where(mask, new, old)
    return type(new)(*(np.where(mask, a, b) for a, b in zip(new, old, strict=True)))
