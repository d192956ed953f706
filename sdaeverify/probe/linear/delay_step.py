"""Matrices of one step of a scheme with a lag on a linear equation, and moments along a run.

    y_{n+1} = R y_n + S v_n + V v_{n+1} + sum_j (R_j y_n + S_j v_n + V_j v_{n+1}) xi_j

y is the scheme's state with k rows, the first d of which are x; the others are algebraic. With tau = (m - delta) h,
as in Qu, Huang & Liu (2010), (2.11),

    v_n = delta x_{n-m+1} + (1 - delta) x_{n-m} .

For m = 1 only the part (1 - delta) x_n of v_{n+1} is known before the step, and the columns of v_{n+1} act on this
part. For m = 0 no part is known, and v_n = x_n.

Bounded nonlinear terms vanish relative to the others at large states, and are arbitrarily close to their derivatives
at small states. A nonlinear step is probed in both limits, since its solutions move between them.

Means and second moments along a run from a deterministic start are exact. A step depends on y_n and the lagged
values v_n, ..., v_{n+m-1}. It adds v_{n+m} = delta x_{n+1} + (1 - delta) x_n, which replaces v_n. The moments of all
other lagged values are unchanged, so that a step costs a multiple of m.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme, flatten
from ...forms import Delayed, Mesh
from ...noise.brownian import Increment
from ..step.nodes import SEED
from ..step.one_step import OneStep
from ..step.states import WHEN
from ..step.times import DIFFERENT, strata
from .affine import AFFINE, at_corners, defect, relative, trial_states, with_trials
from .delay_equation import LARGE, SMALL, UNIT
from .linear_map import MemoryStep


class LinearDelayStep(NamedTuple):
    """The matrices of one step: columns for y_n, for v_n, and for the known part of v_{n+1}.

    Attributes
    ----------
    drift : ndarray, shape (k, k + 2 d)
    noise : ndarray, shape (l, k, k + 2 d)
        Coefficients of independent standard normals xi_j; they include a factor sqrt(h).
    """

    drift: Array
    noise: Array

    @property
    def rows(self) -> int:
        """Number k of components of y."""
        return len(self.drift)

    @property
    def dimension(self) -> int:
        """Number d of components of x, the first components of y."""
        return int(self.drift.shape[1] - self.rows) // 2

    @property
    def maps(self) -> Array:
        """The drift followed by the noises, shape (1 + l, k, k + 2 d)."""
        return np.concatenate([self.drift[None], self.noise])


class Lagged(NamedTuple):
    """A step as a recursion y_{n+1} = sum_i A_i y_{n-i} with noises of the same form, for I distinct lags.

    Attributes
    ----------
    lags : ndarray, shape (I,)
        Ascending, from 0.
    maps : ndarray, shape (1 + l, I, k, k)
        The drift A_i followed by the noises; columns of undelayed components are 0, except at lag 0.
    """

    lags: Array
    maps: Array


def as_recursion(step: LinearDelayStep, mesh: Mesh) -> Lagged:
    """Return a step as a recursion in y only; at most four lags have nonzero coefficients."""
    k, d = step.rows, step.dimension
    now, following = _weights(mesh)
    lags = np.unique([0, *(lag for lag, _ in now + following)])
    maps, sources = np.zeros((len(step.noise) + 1, len(lags), k, k)), step.maps
    maps[:, 0] = sources[..., :k]
    for first, pairs in ((k, now), (k + d, following)):
        for lag, weight in pairs:
            maps[:, np.searchsorted(lags, lag), :, :d] += weight * sources[..., first : first + d]
    used = (lags == 0) | maps.any(axis=(0, 2, 3))
    return Lagged(lags[used], maps[:, used])


def _weights(mesh: Mesh) -> tuple[tuple[tuple[int, float], ...], tuple[tuple[int, float], ...]]:
    # Return pairs (lag, weight): the weights of x_{n-lag} in v_n, and in the known part of v_{n+1}.
    m, delta = mesh
    if m == 0:
        return ((0, 1.0),), ()
    now = ((m - 1, delta), (m, 1.0 - delta))
    return now, tuple((lag - 1, weight) for lag, weight in now if lag > 0)


def arguments(k: int, d: int, mesh: Mesh) -> Array:
    """Return the matrix that maps (y_n, v_n, ..., v_{n+m-1}) to (y_n, v_n, known part of v_{n+1}).

    Parameters
    ----------
    k : int
        Number of rows of the scheme's state y.
    d : int
        Number of components of x.
    mesh : Mesh
        Position of the delay relative to the steps.
    """
    m, delta = mesh
    chosen = np.zeros((k + 2 * d, k + m * d))
    chosen[:k, :k] = np.eye(k)
    chosen[k : k + d, k : k + d] += np.eye(d) if m > 0 else 0.0
    if m == 0:
        chosen[k : k + d, :d] = np.eye(d)
    elif m == 1:
        chosen[k + d :, :d] = (1.0 - delta) * np.eye(d)
    else:
        chosen[k + d :, k + d : k + 2 * d] = np.eye(d)
    return chosen


class Start(NamedTuple):
    """Initial values of a run.

    Attributes
    ----------
    y : ndarray, shape (k,)
        y_0.
    lagged : ndarray, shape (m, d)
        v_0, ..., v_{m-1}, given by the history before the start; v_0, ..., v_N suffice for N steps.
    """

    y: Array
    lagged: Array


class RunMoments(NamedTuple):
    """Moments of a run at every mesh point.

    Attributes
    ----------
    mean : ndarray, shape (N + 1, k)
        E y_n.
    second : ndarray, shape (N + 1, k, k)
        E y_n y_n^T.
    """

    mean: Array
    second: Array


def run_moments(step: LinearDelayStep, mesh: Mesh, start: Start, steps: int) -> RunMoments:
    """Return the moments of a run of `steps` steps.

    Parameters
    ----------
    step : LinearDelayStep
    mesh : Mesh
        Position of the delay relative to the steps.
    start : Start
        State of the scheme, and the lagged values that the run needs.
    steps : int
        Number of steps.

    Returns
    -------
    RunMoments
    """
    # A run shorter than the delay needs no later lagged values.
    k, d, m = step.rows, step.dimension, min(mesh.m, max(steps, 1) + 1)
    known = np.concatenate([start.y, np.ravel(start.lagged[:m]), [1.0]])
    # Second moments of (y_n, all lagged values, 1); the last column contains the means.
    P = np.outer(known, known)
    chosen = arguments(k, d, Mesh(min(m, 2), mesh.delta))
    found = [P[:k, [*range(k), -1]]]
    for n in range(steps):
        lagged = [_places(k, d, (n + i) % m) for i in range(min(m, 2))]
        used = np.concatenate([np.arange(k), *lagged])
        taken = chosen @ P[used]
        _advance(P, step, (taken, taken[:, used] @ chosen.T), lagged[:1], mesh.delta)
        found.append(P[:k, [*range(k), -1]])
    collected = np.array(found)
    return RunMoments(collected[..., -1], collected[..., :-1])


def _places(k: int, d: int, place: int) -> Array:
    return k + d * place + np.arange(d)


def _advance(
    P: Array, step: LinearDelayStep, known: tuple[Array, Array], forgotten: list[Array], delta: float
) -> None:
    # `known` are the moments of z = (y_n, v_n, known part of v_{n+1}) with (y_n, all lagged values, 1), and E z z^T.
    # `forgotten` are the indices of v_n, which v_{n+m} replaces; without a delay there are none.
    k, d, maps = step.rows, step.dimension, step.maps
    second = (maps @ known[1] @ maps.swapaxes(1, 2)).sum(axis=0)
    cross = step.drift @ known[0]
    # Moments of the new lagged value with all known values, with y_{n+1} and with itself.
    fresh = delta * cross[:d] + (1.0 - delta) * P[:d]
    with_y = delta * second[:d] + (1.0 - delta) * cross[:, :d].T
    for slot in forgotten:
        P[slot], P[:, slot], cross[:, slot] = fresh, fresh.T, with_y.T
        P[np.ix_(slot, slot)] = delta * with_y[:, :d] + (1.0 - delta) * fresh[:, :d]
    cross[:, :k] = second
    P[:k], P[:, :k] = cross, cross.T


# Bound of the noise, in standard deviations, at which a step is checked for being affine in the noise; number of
# checks.
# Size: of the noise, and number of checks.
REACH, TRIALS = 4.0, 3
# Only one of this number of probe times after the delay is used.
# Size: times that are tried.
FEWER = 4


class ProbedStep(NamedTuple):
    """Result of probing a step for its matrices.

    Attributes
    ----------
    step : LinearDelayStep
    offset : ndarray, shape (1 + l, k)
        Constant terms of the step: without noise, and coefficients of each noise.
    defect : float
        Relative deviation from linearity in the state and in the noise.
    failed : bool
        Whether the scheme found no root for some input.
    """

    step: LinearDelayStep
    offset: Array
    defect: float
    failed: bool


def probe_step(scheme: Scheme, view: Delayed, h: float, scale: float = UNIT) -> ProbedStep:
    """Return the matrices of a step of size h after the first delay interval.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form.
    h : float
    scale : float
        Size of the states at which the step is evaluated.

    Returns
    -------
    ProbedStep
    """
    k, l = len(flatten(scheme.start(view, 1, h))), view.noise_dim
    inputs = with_trials(_reached(scheme, view, h)) if scale == UNIT else trial_states(k + 2 * view.dimension)
    xi = np.concatenate([np.zeros((l, 1)), np.eye(l), _further_noise(l)], axis=1)
    values, failed = _evaluate_step(scheme, view, h, (scale * inputs, xi), _times_after_delay(view)[0])
    values = values / scale
    factors = at_corners(values[:, : inputs.shape[0] + 1])
    noise = factors[..., 1 : 1 + l] - factors[..., :1]
    expected = factors[..., :1] + np.einsum("ijn,ns->ijs", noise, xi[:, 1 + l :])
    found = factors[..., 1 + l :]
    off = relative(found - expected, np.abs(found).max(axis=1, keepdims=True) + 0.0 * found)
    matrices = np.moveaxis(noise[:-1, :-1], -1, 0)
    step = LinearDelayStep(factors[:-1, :-1, 0], matrices)
    offset = scale * np.concatenate([factors[:-1, -1, :1], noise[:-1, -1]], axis=1).T
    return ProbedStep(step, offset, max(defect(inputs, values[..., : 1 + l], factors[..., : 1 + l]), off), failed)


def _reached(scheme: Scheme, view: Delayed, h: float) -> Array:
    """Return as a column the state at the start of a run and the history at start and end of its first step."""
    known = [view.past(min(0.0, end - view.delay)) for end in (0.0, h)]
    return np.concatenate([flatten(scheme.start(view, 1, h)), *known])


def why_not_lasting_step(scheme: Scheme, view: Delayed, h: float) -> str:
    """Return why the matrices of a step do not hold for all steps after the first delay, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form.
    h : float
        Step size.
    """
    inputs = trial_states(len(flatten(scheme.start(view, 1, h))) + 2 * view.dimension)
    at = inputs, np.ones((view.noise_dim, 1))
    first, *others = (_evaluate_step(scheme, view, h, at, t)[0] for t in _times_after_delay(view))
    return "" if all(relative(other - first, np.abs(first)) <= AFFINE for other in others) else DIFFERENT


def why_not_lasting_run(scheme: Scheme, view: Delayed, h: float) -> str:
    """Return why the matrices do not hold for all steps of a run, including those in the first delay interval.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form.
    h : float
        Step size.
    """
    if _grows_as_steps_shrink(scheme, view):
        return "the scheme's state has more components on shorter steps"
    if reason := why_not_lasting_step(scheme, view, h):
        return reason
    probed, t = probe_step(scheme, view, h), min(WHEN * view.delay, view.delay - h)
    known = np.concatenate([view.past(t - view.delay), view.past(min(0.0, t + h - view.delay))])
    memory = trial_states(probed.step.rows)
    inputs = np.concatenate([memory, np.repeat(known, memory.shape[1], axis=1)])
    made = _evaluate_step(scheme, view, h, (inputs, np.zeros((view.noise_dim, 1))), t)[0][..., 0]
    expected = probed.step.drift @ inputs + probed.offset[0, :, None]
    return "" if relative(made - expected, np.abs(expected)) <= AFFINE else DIFFERENT


def _grows_as_steps_shrink(scheme: Scheme, view: Delayed) -> bool:
    # A history stored in the state has k ~ 1/h components, and second moments over N steps would cost
    # k^2 N = O(h^-3).
    long, short = (len(flatten(scheme.start(view, 1, view.delay / parts))) for parts in (4.0, 8.0))
    return short > long


def _times_after_delay(view: Delayed) -> tuple[float, ...]:
    """Return times after the first delay: earlier, lagged values come from the history, which a scheme may know."""
    left = view.horizon - view.delay
    return tuple(view.delay + part for part in (strata(left)[::FEWER] if left > 0.0 else (0.0,)))


def run_start(scheme: Scheme, view: Delayed, h: float, steps: int) -> Start:
    """Return the initial values of a run with steps of size h: the scheme's state, and the lagged values it needs.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form.
    h : float
        Step size.
    steps : int
        Number of steps; lagged values that the run does not need are left out.
    """
    used = min(view.mesh(h).m, max(steps, 1) + 1)
    lagged = [view.past(min(0.0, n * h - view.delay))[:, 0] for n in range(used)]
    return Start(flatten(scheme.start(view, 1, h))[:, 0], np.array(lagged))


def limits(scheme: Scheme, view: Delayed, h: float) -> tuple[float, ...]:
    """Return sizes of states at which a step is linear: 1 for a linear step, else those of a small and a large one.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form.
    h : float
        Step size.
    """
    if probe_step(scheme, view, h).defect <= AFFINE:
        return (UNIT,)
    return tuple(size for size in (SMALL, LARGE) if probe_step(scheme, view, h, size).defect <= AFFINE)


def _evaluate_step(scheme: Scheme, view: Delayed, h: float, at: tuple[Array, Array], t: float) -> tuple[Array, bool]:
    """Return the new states for all inputs, shape (k, S, K), of a step at time t for every column of noise."""
    inputs, xi = at
    d, count = view.dimension, xi.shape[1]
    z, dW = np.repeat(inputs, count, axis=1), np.sqrt(h) * np.tile(xi, inputs.shape[1])
    noise = Increment(dW, np.zeros_like(dW), lagged=z[-2 * d : -d], ahead=z[-d:])
    after, failed = MemoryStep(OneStep(scheme, view), h).advance(z[: -2 * d], noise, t)
    return after.reshape(-1, inputs.shape[1], count), failed


def _further_noise(l: int) -> Array:
    rng = np.random.Generator(np.random.Philox(key=SEED + 7))
    return np.asarray(REACH * rng.uniform(-1.0, 1.0, (l, TRIALS)))
