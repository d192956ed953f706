"""Error of y if the delay is no multiple of the step size: y solves the constraint with an interpolated past value.

On a mesh with tau = (m - delta) h the lagged value at the end of a step is

    xb = delta x(t_a + h) + (1 - delta) x(t_a),   t_a + delta h = t + h - tau,

whereas the solution at t_a + delta h differs by a Brownian bridge of variance h delta (1 - delta) g g^T. An error
of y does not propagate to the next step: y = U(x, v) has the order of x or, if that is lower, the order in h of

    || y_{n+1} - U(t + h, x_{n+1}, x(t_a + delta h)) ||_{L2} .
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Delayed
from ...forms.delay.linked import X
from ...noise.brownian import Increment
from ..step.nodes import normal_rule
from ..step.one_step import OneStep
from ..step.states import cloud
from .delay_links import Y, remove_delay
from .orders import worst_order
from .strong_defects import LEVELS

# Size: nodes of a variable.
NODES = 4


class AlgebraicDefects(NamedTuple):
    """Defects of y after a step at S states and H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
    rms : ndarray, shape (S, H)
        L2 norms of the defects.
    scale : ndarray, shape (S, H)
        Largest absolute value of y.
    """

    h: Array
    rms: Array
    scale: Array


def algebraic_defects(scheme: Scheme, view: Delayed, delta: float) -> AlgebraicDefects:
    """Compute the defects of y after one step of each size after the first delay.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem with algebraic components, for which the scheme solves; see `keeps_constraint`.
    delta : float
        Position of the delay on the mesh, from 0 to 1.

    Returns
    -------
    AlgebraicDefects
    """
    step = OneStep(*remove_delay(scheme, view))
    x, h = cloud(step.view, step.equation), LEVELS * step.time_unit
    with np.errstate(all="ignore"):
        found = [_level(scheme, view, np.split(x, 2), step.time, (float(size), delta)) for size in h]
    rms, scale = (np.stack(parts, axis=-1) for parts in zip(*found, strict=True))
    return AlgebraicDefects(h, rms, scale)


def algebraic_order(record: AlgebraicDefects) -> float:
    """Return the lowest order over the states; infinite if the errors are rounding, NaN if they are not finite."""
    return worst_order(record.h, record.rms, record.scale)


def _level(
    scheme: Scheme, view: Delayed, states: list[Array], s: float, at: tuple[float, float]
) -> tuple[Array, Array]:
    """Return the root mean squares and the scale, shape (S,), for steps of size h with the mesh position delta."""
    (h, delta), t = at, s + view.delay
    rule = normal_rule(3 * view.noise_dim, NODES)
    now, old = (np.repeat(part, len(rule.weights), axis=1) for part in states)
    own, before, after = np.split(np.tile(np.sqrt(h) * rule.x, states[0].shape[1]), 3)
    plain, none, past = view.without_y(), now[:0], view.past(min(0.0, s - view.delay)) + 0.0 * old
    f = plain.drift(s, old, past, none)
    between = old + delta * h * f + plain.diffused(s, old, past, none, np.sqrt(delta) * before)
    end = between + (1.0 - delta) * h * f + plain.diffused(s, old, past, none, np.sqrt(1.0 - delta) * after)
    noise = Increment(own, np.zeros_like(own), lagged=old, ahead=delta * end + (1.0 - delta) * old)
    state = scheme.enter(view, view.consistent(t, now, old), t, h)
    made = scheme.parts(view, scheme.prepare(view, h)(state, t, noise).state)
    off = made[Y] - view.eliminated(t + h, made[X], between)
    squares = (off**2).sum(axis=0).reshape(-1, len(rule.weights))
    largest = np.abs(made[Y]).max(axis=0).reshape(squares.shape)
    return np.sqrt(squares @ rule.weights), largest.max(axis=1)
