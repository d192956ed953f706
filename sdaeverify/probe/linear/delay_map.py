"""The linear map of a step with a delay, found by evaluating it: its state and the lagged values to the new state.

Bounded nonlinear terms vanish beside the others at large states, and differ from their derivatives as little as one
likes at small ones. A step that is not linear is looked at in both limits, between which its solutions move.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme, flatten
from ...forms import Delayed
from ...noise.brownian import Increment
from ..step.nodes import SEED
from ..step.one_step import OneStep
from ..step.states import WHEN
from ..step.times import DIFFERENT, ELSEWHEN
from .affine import AFFINE, at_corners, defect, relative, trial_states
from .delay_equation import LARGE, SMALL, UNIT
from .delay_moments import Start
from .delay_step import LinearDelayStep
from .linear_map import MemoryStep

# Noise at which the step must be what it is by its values at 0 and at one standard deviation.
REACH, TRIALS = 4.0, 3


class ProbedStep(NamedTuple):
    """What was found.

    Attributes
    ----------
    step : LinearDelayStep
    offset : ndarray, shape (1 + l, k)
        What a step adds to linear terms: without noise, and for one standard deviation of each noise.
    defect : float
        Of linearity in the state and in the noise, relative.
    failed : bool
        Whether the scheme found no root somewhere.
    """

    step: LinearDelayStep
    offset: Array
    defect: float
    failed: bool


def probed_step(scheme: Scheme, view: Delayed, h: float, scale: float = UNIT) -> ProbedStep:
    """Return the matrices of a step of size h after the first delay.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Of the scheme's form.
    h : float
    scale : float
        Size of the states at which it is evaluated.

    Returns
    -------
    ProbedStep
    """
    k, l = len(flatten(scheme.start(view, 1, h))), view.noise_dim
    inputs = trial_states(k + 2 * view.dimension)
    xi = np.concatenate([np.zeros((l, 1)), np.eye(l), _further(l)], axis=1)
    values, failed = _evaluated(scheme, view, h, (scale * inputs, xi), _later(view)[0])
    values = values / scale
    factors = at_corners(values[:, : inputs.shape[0] + 1])
    noise = factors[..., 1 : 1 + l] - factors[..., :1]
    expected = factors[..., :1] + np.einsum("ijn,ns->ijs", noise, xi[:, 1 + l :])
    found = factors[..., 1 + l :]
    off = relative(found - expected, np.abs(found).max(axis=1, keepdims=True) + 0.0 * found)
    matrices = np.moveaxis(noise[:-1, :-1], -1, 0)
    step = LinearDelayStep(factors[:-1, :-1, 0], matrices)
    offset = scale * np.concatenate([factors[:-1, -1, :1], noise[:-1, -1]], axis=1).T
    return ProbedStep(step, offset, max(defect(values[..., : 1 + l], factors[..., : 1 + l]), off), failed)


def no_lasting_step(scheme: Scheme, view: Delayed, h: float) -> str:
    """Return why the matrices of a step are not those of all steps after the first delay, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        The problem as the scheme sees it.
    h : float
        Step size.
    """
    inputs, xi = (
        trial_states(len(flatten(scheme.start(view, 1, h))) + 2 * view.dimension),
        np.ones((view.noise_dim, 1)),
    )
    first, *others = (_evaluated(scheme, view, h, (inputs, xi), t)[0] for t in _later(view))
    return "" if all(relative(other - first, np.abs(first)) <= AFFINE for other in others) else DIFFERENT


def no_lasting_run(scheme: Scheme, view: Delayed, h: float) -> str:
    """Return why the matrices are not those of all steps of a run, those that the history drives among them.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        The problem as the scheme sees it.
    h : float
        Step size.
    """
    if reason := no_lasting_step(scheme, view, h):
        return reason
    probed, t = probed_step(scheme, view, h), min(WHEN * view.delay, view.delay - h)
    known = np.concatenate([view.past(t - view.delay), view.past(min(0.0, t + h - view.delay))])
    memory = trial_states(probed.step.rows)
    inputs = np.concatenate([memory, np.repeat(known, memory.shape[1], axis=1)])
    made = _evaluated(scheme, view, h, (inputs, np.zeros((view.noise_dim, 1))), t)[0][..., 0]
    expected = probed.step.drift @ inputs + probed.offset[0, :, None]
    return "" if relative(made - expected, np.abs(expected)) <= AFFINE else DIFFERENT


def _later(view: Delayed) -> tuple[float, ...]:
    """Return times after the first delay: before, the lagged values are the history's, and a scheme may know them."""
    left = max(view.horizon - view.delay, 0.0)
    return tuple(view.delay + part * left for part in (WHEN, *ELSEWHEN))


def run_start(scheme: Scheme, view: Delayed, h: float, steps: int) -> Start:
    """Return where a run with steps of size h begins: the scheme's state, and the lagged values that so many use.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        The problem as the scheme sees it.
    h : float
        Step size.
    steps : int
        Length of the run: no lagged value is returned that it does not use.
    """
    used = min(view.mesh(h).m, max(steps, 1) + 1)
    lagged = [view.past(min(0.0, n * h - view.delay))[:, 0] for n in range(used)]
    return Start(flatten(scheme.start(view, 1, h))[:, 0], np.array(lagged))


def limits(scheme: Scheme, view: Delayed, h: float) -> tuple[float, ...]:
    """Return the sizes of states at which a step is linear: one of a linear step, else a small and a large one.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        The problem as the scheme sees it.
    h : float
        Step size.
    """
    if probed_step(scheme, view, h).defect <= AFFINE:
        return (UNIT,)
    return tuple(size for size in (SMALL, LARGE) if probed_step(scheme, view, h, size).defect <= AFFINE)


def _evaluated(scheme: Scheme, view: Delayed, h: float, at: tuple[Array, Array], t: float) -> tuple[Array, bool]:
    """Return the new states at all inputs, shape (k, S, K), of a step at time t for every column of noise."""
    inputs, xi = at
    d, count = view.dimension, xi.shape[1]
    z, dW = np.repeat(inputs, count, axis=1), np.sqrt(h) * np.tile(xi, inputs.shape[1])
    noise = Increment(dW, np.zeros_like(dW), lagged=z[-2 * d : -d], ahead=z[-d:])
    after, failed = MemoryStep(OneStep(scheme, view), h).advance(z[: -2 * d], noise, t)
    return after.reshape(-1, inputs.shape[1], count), failed


def _further(l: int) -> Array:
    rng = np.random.Generator(np.random.Philox(key=SEED + 7))
    return np.asarray(REACH * rng.uniform(-1.0, 1.0, (l, TRIALS)))
