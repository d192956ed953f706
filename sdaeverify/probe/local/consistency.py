"""Consistency of one step: whether it follows the equation, with any order.

With d = Phi_h(x; dW) - [x + f h + B dW], a scheme is consistent if h^{-1/2} ||d||_{L2} and h^{-1} |E d| tend to 0
(Lindner & Stroot 2017, Definition 4.7). If it is also semi-stable it converges, without a rate. For a wrong
diffusion ||d|| has order 1/2, for a wrong drift |E d| has order 1; for a scheme of order p both are higher
by p.

An error of a first step may be cancelled by later steps, as by a velocity in the tangent space of the previous
point. So a step from a state that the scheme itself has reached is also probed.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Delayed, Problem
from ...noise.brownian import Increment
from ..step.component_units import component_units
from ..step.nodes import SEED, HalfSteps, Nodes, half_steps, law_nodes, product_rule, step_nodes
from ..step.one_step import OneStep
from ..step.states import cloud, time_unit
from .delay_links import remove_delay
from .orders import ROUNDING, last_orders, worst_order
from .reach import mark_rows, reach
from .strong_defects import LEVELS

# Step sizes in units of the horizon, or of time if that is shorter: small enough that right terms do not hide an
# error of one per cent of the noise.
SIZES = 4.0 ** -np.array([6.0, 8.0, 10.0, 12.0])
# Size: nodes of a variable.
NODES = 4


class Consistency(NamedTuple):
    """Defects of one step at C components, S states and H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
    rms, mean : ndarray, shape (2, C, S, H)
        ||d||_{L2} and |E d| over the rows of each component, in its unit: for a step from each state, and for a step
        from the state that the scheme reaches from there.
    scale : ndarray, shape (S, H)
        Largest absolute value of the components of the state.
    reached : ndarray, shape (C, C)
        1 in row i and column j if errors of component j affect component i, see `reach`; else 0.
    """

    h: Array
    rms: Array
    mean: Array
    scale: Array
    reached: Array


def consistency(scheme: Scheme, view: Problem) -> Consistency:
    """Compute the defects of one step of each size from each state of `cloud`.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; its one-step map can be probed.

    Returns
    -------
    Consistency
    """
    step = OneStep(scheme, view)
    x, sizes = cloud(view, step.equation), SIZES * time_unit(view)
    nodes = step_nodes(view.noise_dim, NODES, areas="H" in scheme.noise)
    if not nodes.exact:
        nodes, _ = law_nodes(view.noise_dim, scheme.noise)
    with np.errstate(all="ignore"):
        levels = [_defects(step, x, nodes, float(h)) for h in sizes]
        rms, mean, scale = (np.stack(parts, axis=-1) for parts in zip(*levels, strict=True))
        units = component_units(step, x, float(sizes[0]))[:, None, None]
        return Consistency(sizes, rms / units, mean / units, scale, reach(step, x))


def consistency_orders(record: Consistency, component: int | None = None) -> tuple[Array, Array]:
    """Return the lowest orders in h of the defects of a component, or of the full state.

    Parameters
    ----------
    record : Consistency
    component : int, optional
        Index of the component, including all components whose errors affect it; by default the full state.

    Returns
    -------
    ndarray, shape (2, S)
        Orders of ||d||_{L2}, for a first and a later step, at each state.
    ndarray, shape (2, S)
        The same for |E d|.
    """
    rows = mark_rows(record.reached, component)
    rms, mean = (
        last_orders(record.h, part[:, rows], ROUNDING * record.scale, record.scale).order.min(axis=1)
        for part in (record.rms, record.mean)
    )
    return rms, mean


def _defects(step: OneStep, x: Array, nodes: Nodes, h: float) -> tuple[Array, Array, Array]:
    """Return root mean squares and means of the defects, shape (2, C, S), and the scale, shape (S,)."""
    states, t = x.shape[1], step.time
    wide, noise = np.repeat(x, len(nodes.weights), axis=1), nodes.increment(h, states)
    first = step(wide, t, h, noise) - step.euler(wide, t, h, noise)
    state = step.advance(step.enter(wide, t, h), t, h, _random_increments(nodes, h, states))
    gone = step.read(state)
    later = step.read(step.advance(state, t + h, h, noise)) - step.euler(gone, t + h, h, noise)
    defects = np.stack([first, later]).reshape(2, len(x), states, -1)
    squares = nodes.mean(defects**2), nodes.mean(defects) ** 2
    rms, mean = (
        np.sqrt(np.stack([part[:, rows].sum(axis=1) for rows in step.names.values()], axis=1)) for part in squares
    )
    return rms, mean, np.abs(x).max(axis=0)


def _random_increments(nodes: Nodes, h: float, states: int) -> Increment:
    """Return one random increment per state, the same at all nodes and, up to the factor sqrt(h), for all h."""
    rng, count = np.random.Generator(np.random.Philox(key=SEED + 2)), len(nodes.weights)
    dW, H = (np.repeat(np.sqrt(h) * rng.standard_normal((len(nodes.dW), states)), count, axis=1) for _ in range(2))
    return Increment(dW, None if nodes.H is None else H / np.sqrt(12.0))


# Consistency of one step with a delay given its past, Definition 3.1 of Qu, Huang & Liu (2010).
#
# A scheme is consistent of order p if its local error r satisfies ||E(r | F_t)||_{L2} <= C h^{p+1} and
# ||r||_{L2} <= C h^{p+1/2}. The condition F_t includes all events up to t, and with these the solution one delay ago
# over the whole step: its Brownian motion is fixed while means over the step's current noise are taken. The local
# error is the difference between a step and two half steps.


# Size: nodes of a variable.
DELAY_NODES = 5


class DelayConsistency(NamedTuple):
    """Defects of one step of x at S states and H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
    rms : ndarray, shape (S, H)
        ||r||_{L2}.
    mean : ndarray, shape (S, H)
        ||E(r | F_t)||_{L2}, with the mean square over the past.
    scale : ndarray, shape (S, H)
        Largest absolute value of the components before and after the step.
    """

    h: Array
    rms: Array
    mean: Array
    scale: Array


def why_not_delay_consistency(scheme: Scheme, view: Delayed) -> str:
    """Return why a step cannot be probed given its past, or an empty string."""
    if scheme.law.bounded or "H" in scheme.noise:
        return "a step that starts from the exact past is probed with Brownian increments only"
    nodes = half_steps(2 * view.noise_dim, DELAY_NODES, rule=product_rule)
    return "" if nodes.whole.exact else "its noise has too many dimensions for a quadrature rule"


def delay_consistency(scheme: Scheme, view: Delayed) -> DelayConsistency:
    """Compute the local errors of one step of each size after the first delay, from one step and two half steps.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form; `why_not_delay_consistency` is empty for the pair.

    Returns
    -------
    DelayConsistency
    """
    step = OneStep(*remove_delay(scheme, view))
    x, nodes = cloud(step.view, step.equation), half_steps(2 * view.noise_dim, DELAY_NODES, rule=product_rule)
    h = LEVELS * step.time_unit
    with np.errstate(all="ignore"):
        found = [_level(step, x, nodes, float(size)) for size in h]
    rms, mean, scale = (np.stack(parts, axis=-1) for parts in zip(*found, strict=True))
    return DelayConsistency(h, rms, mean, scale)


def consistency_order(record: DelayConsistency) -> float:
    """Return the order p of Definition 3.1; infinite if the defects are rounding, NaN if they are not finite."""
    of_rms, of_mean = (worst_order(record.h, part, record.scale) for part in (record.rms, record.mean))
    return float(np.minimum(of_rms - 0.5, of_mean - 1.0))


def _level(step: OneStep, x: Array, nodes: HalfSteps, h: float) -> tuple[Array, Array, Array]:
    states, weights, t = x.shape[1], nodes.whole.weights, step.time
    wide, d = np.repeat(x, len(weights), axis=1), len(x) // 2
    whole, first, second = (part.increment(h, states) for part in nodes)
    once, middle = step(wide, t, h, whole), step(wide, t, 0.5 * h, first)
    defects = (once - step(middle, t + 0.5 * h, 0.5 * h, second))[:d].reshape(d, states, -1)
    given_past, shares = _condition_on_past(defects, weights, step.view.noise_dim // 2)
    scale = np.maximum(np.abs(x).max(axis=0), np.abs(once).max(axis=0).reshape(states, -1).max(axis=1))
    rms = np.sqrt(np.einsum("dsk,k->s", defects**2, weights))
    return rms, np.sqrt(np.einsum("dsk,k->s", given_past**2, shares)), scale


def _condition_on_past(defects: Array, weights: Array, l: int) -> tuple[Array, Array]:
    """Return the means over the step's current noise at the nodes of the past, and the weights of these nodes.

    Nodes are a product of 4 l rules: of the first half step, for the l current motions and those one delay ago, and
    of the second half step in the same way.
    """
    count = round(len(weights) ** (1.0 / (4 * l)))
    shape, own = (count,) * (4 * l), (*range(l), *range(2 * l, 3 * l))
    full, products = weights.reshape(shape), (defects * weights).reshape(*defects.shape[:2], *shape)
    shares = full.sum(axis=own)
    means = products.sum(axis=tuple(axis + 2 for axis in own)) / shares
    return means.reshape(*defects.shape[:2], -1), shares.ravel()
