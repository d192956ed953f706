"""Which components' errors affect which others, through the equation or through the steps of the scheme.

An error in component j affects i if a coefficient of i, or component i after two steps of a scheme, depends on j, or
on a component that j affects. Dependence is tested by perturbing one component at many states, by large and small
amounts, because it may vanish at some states or times. An affected component is judged together with the errors that
affect it, any other component alone.
"""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from ...arrays import Array, Mask, each
from ...forms import Equation
from ...noise.brownian import Increment
from ...numerics.newton import SOLVED
from ..step.nodes import SEED
from ..step.one_step import OneStep
from ..step.states import WHEN

# Parts of the horizon at which coefficients are evaluated, and relative sizes of the perturbations of a component.
# Size: times, and sizes of perturbations.
TIMES, MOVES = (0.0, WHEN, 0.55, 0.9), (1.0, 1e-3)
# Step size, in units of time.
# Size: of a step.
STEP = 2.0**-4
Names = Mapping[str, slice]


def reach(step: OneStep, x: Array) -> Array:
    """Return which errors affect which components.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S)
        States at which dependence is tested.

    Returns
    -------
    ndarray, shape (C, C)
        1 in row i and column j if an error in component j affects i, and on the diagonal; else 0.
    """
    found = np.eye(len(step.names), dtype=bool)
    for depends in (partial(_by_coefficients, step.equation, step.names), partial(_by_steps, step)):
        if not found.all():
            found = _close(found | depends(x))
    return found.astype(float)


def core(equation: Equation, names: Names, x: Array) -> Mask:
    """Return the components on which a coefficient depends, shape (C,); the others are pure outputs.

    If there is no dependence at all, as for dx = c dt + S dW, all components are returned.

    Parameters
    ----------
    equation : Equation
    names : mapping of str to slice
        Rows of the components.
    x : ndarray, shape (d, S)
        States at which dependence is tested.
    """
    found = _by_coefficients(equation, names, x).any(axis=0)
    return np.asarray(found if found.any() else ~found)


def mark_rows(reached: Array, component: int | None) -> Mask:
    """Return the mask of the components that affect a given one, including itself; all if `component` is None."""
    return np.ones(len(reached), dtype=bool) if component is None else reached[component] > 0.0


def _close(direct: Mask) -> Mask:
    """Return the transitive closure of a dependence."""
    for _ in direct:
        direct = direct | (direct.astype(int) @ direct.astype(int) > 0)
    return direct


def _by_coefficients(equation: Equation, names: Names, x: Array) -> Mask:
    d = len(x)

    def coefficients(states: Array) -> Array:
        paths, found = states.shape[1], []
        for t in np.array(TIMES) * equation.horizon:
            f, B = equation.drift(float(t), states), equation.diffusion(float(t), states)
            found += [np.broadcast_to(f, (d, paths))[:, None], np.broadcast_to(B, (d, equation.noise_dim, paths))]
        return np.concatenate(found, axis=1)

    return _depends(names, _moved(names, x), coefficients)


def _by_steps(step: OneStep, x: Array) -> Mask:
    """Test dependence over two steps, because the second one begins with the memory left by the first."""
    h, t = STEP * step.time_unit, step.time
    states, noises = _moved(step.names, x), _draw(step, h, x.shape[1])
    if step.view.has_constraints:
        nearest = step.view.admissible(states.reshape(len(x), -1)).reshape(states.shape)
        states = np.where(np.isfinite(nearest).all(axis=0), nearest, x[:, None])
    if step.view.domain is not None:
        unmoved = np.broadcast_to(x[:, None], states.shape).reshape(len(x), -1)
        states = step.view.domain.keep(states.reshape(len(x), -1), unmoved).reshape(states.shape)

    def steps(wide: Array) -> Array:
        state = step.enter(wide, t, h)
        for number, noise in enumerate(noises):
            same = each(lambda part: np.tile(part, states.shape[1]), noise)
            state = step.advance(state, t + number * h, h, same)
        return step.read(state)[:, None]

    return _depends(step.names, states, steps)


def _draw(step: OneStep, h: float, paths: int) -> list[Increment]:
    """Return the noise of two steps with the scheme's law; has H if the scheme uses it."""
    rng, found = np.random.Generator(np.random.Philox(key=SEED + 11)), []
    for _ in range(2):
        noise = step.view.drawn(rng, h, paths)
        if noise.H is None and "H" in step.scheme.noise:
            noise = noise._replace(H=np.sqrt(h / 12.0) * rng.standard_normal(noise.dW.shape))
        found.append(step.scheme.law.increment(noise, h))
    return found


def _moved(names: Names, x: Array) -> Array:
    """Return the states followed by copies with one component perturbed, shape (d, 1 + C M, S)."""
    states = np.repeat(x[:, None], 1 + len(names) * len(MOVES), axis=1)
    move = (1.0 + np.abs(x)) * np.cos(np.arange(1.0, len(x) + 1))[:, None]
    for index, rows in enumerate(names.values()):
        for number, size in enumerate(MOVES):
            states[rows, 1 + index * len(MOVES) + number] += size * move[rows]
    return states


def _depends(names: Names, states: Array, function: Callable[[Array], Array]) -> Mask:
    """Return which components of a function (d, P) -> (d, K, P) depend on which, from values at `_moved` states."""
    d, copies, count = states.shape
    with np.errstate(all="ignore"):
        values = function(states.reshape(d, -1)).reshape(d, -1, copies, count)
        before = values[:, :, :1]
        change = np.abs(values[:, :, 1:] - before)
    found = []
    for rows in names.values():
        # Entries are compared one by one. Entries that are not finite at the unperturbed state are skipped.
        size = np.max(np.abs(before[rows]), axis=-1, keepdims=True, initial=0.0, where=np.isfinite(before[rows]))
        found.append((change[rows] > SOLVED * size).any(axis=(0, 1, 3)).reshape(-1, len(MOVES)).any(axis=1))
    return np.array(found)
