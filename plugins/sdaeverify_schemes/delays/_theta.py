"""One step of the stochastic theta method for index-1 delay equations, Qu, Huang & Liu (2010), (2.10).

    x+ = x + h [theta f(t + h, x+, v+, y+) + (1 - theta) f(t, x, v, y)] + g(t, x, v, y) dW,
     0 = u(t + h, x+, v+, y+)

with the lagged values v and v+; if the delay is shorter than a step, v+ = known + delta x+ is part of the implicit
equations.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, DelaySDAE, DelayState, Increment, Lag, Step
from sdaeverify.numerics import Root, largest, newton, update_tolerance

from ._root import hold_failed, regular


class Begun(NamedTuple):
    """A step up to its implicit part.

    Attributes
    ----------
    lag : Lag
    known : ndarray, shape (d, P)
        Explicit terms x + h (1 - theta) f + g dW.
    guess : DelayState
        Initial guess: x after the explicit step, and the old y.
    """

    lag: Lag
    known: Array
    guess: DelayState


def begin_step(problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment, theta: float) -> Begun:
    """Return the explicit part of a step."""
    (x, y), lag = state, problem.lag(state.x, h, noise)
    f, kick = problem.drift(t, x, lag.now, y), problem.diffused(t, x, lag.now, y, noise.dW)
    return Begun(lag, x + h * (1.0 - theta) * f + kick, DelayState(x + h * f + kick, y))


def solve_coupled(problem: DelaySDAE, begin: Begun, t: float, s: float) -> Root:
    """Solve x = known + s f(t, x, v, y), 0 = u(t, x, v, y) for (x, y) simultaneously, with lagged v = v(x).

    Parameters
    ----------
    problem : DelaySDAE
    begin : Begun
    t, s : float
        Time of the step's end, and theta h.

    Returns
    -------
    Root
    """
    d, lag, unit = problem.dimension, begin.lag, np.eye(problem.dimension)[..., None]

    def matrix(x: Array, v: Array, y: Array) -> Array:
        df = problem.linearised_drift(t, x, v, y)
        top = [unit - s * lag.total(df), -s * df.y]
        if problem.constraint is None:
            return top[0]
        du = problem.linearised_constraint(t, x, v, y)
        return _blocks([top, [lag.total(du), du.y]], x.shape[-1])

    def linearised(z: Array) -> tuple[Array, Callable[[], Array]]:
        x, y = z[:d], z[d:]
        v = lag.ahead(x)
        value = x - begin.known - s * problem.drift(t, x, v, y)
        whole = value if problem.constraint is None else np.concatenate([value, problem.constraint(t, x, v, y)])
        return whole, lambda: matrix(x, v, y)

    return run_newton(linearised, np.concatenate(begin.guess), begin.known, begin.lag.known)


def algebraic(problem: DelaySDAE, lag: Lag, t: float, x: Array, guess: Array) -> Root:
    """Solve 0 = u(t, x, v, y) for y, with given x and lagged value."""
    v, constraint = lag.ahead(x), problem.constraint
    if constraint is None or problem.solved is not None:
        y = guess if constraint is None else problem.eliminated(t, x, v)
        return Root(y, np.ones(x.shape[-1], dtype=bool), np.zeros(x.shape[-1], dtype=np.int64))

    def linearised(y: Array) -> tuple[Array, Callable[[], Array]]:
        return constraint(t, x, v, y), lambda: problem.linearised_constraint(t, x, v, y).y

    return run_newton(linearised, guess, x, v)


def run_newton(linearised: Callable[[Array], tuple[Array, Callable[[], Array]]], *given: Array) -> Root:
    """Run Newton's method from the first of the given arrays; the size of all of them scales its tolerance."""
    return newton(linearised, given[0], update_tolerance(*map(largest, given)))


def delay_theta(problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment, theta: float) -> Step:
    """Make one step with parameter theta."""
    begin = begin_step(problem, state, t, h, noise, theta)
    if theta == 0.0:
        root = algebraic(problem, begin.lag, t + h, begin.guess.x, state.y)
        new = DelayState(begin.guess.x, root.x)
    else:
        root = solve_coupled(problem, begin, t + h, theta * h)
        new = DelayState(root.x[: problem.dimension], root.x[problem.dimension :])
    sound = root.converged & regular(problem, begin.lag, (t, t + h), state, new)
    return hold_failed(state, new, root._replace(converged=sound))


def _blocks(rows: list[list[Array]], paths: int) -> Array:
    d, whole = len(rows[0][0]), sum(block.shape[1] for block in rows[0])
    full = np.empty((whole, whole, paths))
    for place, row in zip((slice(d), slice(d, None)), rows, strict=True):
        full[place, :d], full[place, d:] = row
    return full
