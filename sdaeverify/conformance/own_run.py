"""States along a run of a scheme, where iterations, truncation and constraints are active."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..contracts.scheme import Scheme, State, require_step
from ..forms import Problem
from ..noise.brownian import BROWNIAN, USUAL, Brownian, Increment, Source
from .batches import freeze

# Most steps over the horizon; with more paths than this, several paths are stopped at the same step.
STEPS = 16


def stopped_states(scheme: Scheme, view: Any, paths: int) -> State:
    """Return states along a run over the horizon: each path is stopped at another time.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    paths : int

    Returns
    -------
    ndarray or NamedTuple of ndarray
        Read-only.
    """
    steps = min(paths, STEPS)
    h, last = view.horizon / steps, np.arange(paths) * steps // paths
    noises = [scheme.law.increment(level_noise(view, paths, h, n), h) for n in range(last[-1] + 1)]
    stops = [stop.state for stop in stops_along(scheme, view, h, noises)]
    if not isinstance(stops[0], tuple):
        return freeze(_stop(stops, last))
    return freeze(type(stops[0])(*(_stop(part, last) for part in zip(*stops, strict=True))))


class Stop(NamedTuple):
    """A state of a run, the noise of the next step, and the state after it."""

    state: State
    noise: Increment
    end: State


def stops_along(scheme: Scheme, problem: Problem, h: float, noises: Sequence[Increment]) -> Iterator[Stop]:
    """Yield the steps of size h of a run from the scheme's start; states and noise given to the step are read-only.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
        Problem in the scheme's form.
    h : float
    noises : sequence of Increment, dW of shape (l, P)
        Noise with the scheme's law, one for each step.

    Yields
    ------
    Stop
    """
    paths = noises[0].dW.shape[-1]
    state, stepper, recall = scheme.start(problem, paths, h), scheme.prepare(problem, h), problem.recall(h, paths)
    for n, drawn in enumerate(noises):
        stop, noise = freeze(state), freeze(drawn if recall is None else recall.add_past(drawn))
        state = require_step(stepper(stop, n * h, noise)).state
        if recall is not None:
            recall.push(scheme.parts(problem, state)["x"])
        yield Stop(stop, noise, state)


def level_noise(view: Any, paths: int, h: float, block: int) -> Increment:
    """Return the noise of one step, drawn by address.

    Parameters
    ----------
    view : Problem
        Problem in the scheme's form.
    paths : int
    h : float
        Step size.
    block : int
        Index of the draw; different indices give independent noise.
    """
    source = Source(1, "conformance", block, paths)
    noise = Brownian(source, view.noise_dim, h, 0, view.noise & {*BROWNIAN} | USUAL, view.records)
    _, first = next(next(noise.pieces()))
    return first.increment(0)


def _stop(stops: Sequence[Array], last: Array) -> Array:
    # Return the state of each path after its last step.
    return np.stack([stops[n][..., path] for path, n in enumerate(last)], axis=-1)
