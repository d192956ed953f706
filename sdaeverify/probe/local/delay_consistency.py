"""Consistency of one step with a delay given its past, Definition 3.1 of Qu, Huang & Liu (2010).

A scheme is consistent of order p if its local error r obeys ||E(r | F_t)||_{L2} <= C h^{p+1} and
||r||_{L2} <= C h^{p+1/2}. Given is all that has happened up to t, and with it the solution one delay ago over the
whole step: its Brownian motion is held while means over the step's own are taken. The local error is the difference
between a step and two half steps.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import DelaySDAE
from ..step.nodes import HalfSteps, half_steps
from ..step.one_step import OneStep
from ..step.states import WHEN, cloud
from .delay_links import linked
from .orders import last_orders
from .strong_defects import LEVELS, ROUNDING

NODES = 5


class DelayConsistency(NamedTuple):
    """Defects of one step of x at S states and H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
    rms : ndarray, shape (S, H)
        ||r||_{L2}.
    mean : ndarray, shape (S, H)
        ||E(r | F_t)||_{L2}, the mean square being taken over the past.
    scale : ndarray, shape (S, H)
        Largest absolute value in the state, before and after the step.
    """

    h: Array
    rms: Array
    mean: Array
    scale: Array


def no_delay_consistency(scheme: Scheme, view: DelaySDAE) -> str:
    """Return why a step cannot be probed given its past, or an empty string."""
    if scheme.law.bounded or "H" in scheme.noise:
        return "a step given its past is probed with Brownian increments alone"
    nodes = half_steps(2 * view.noise_dim, NODES)
    return "" if nodes.whole.exact else "its noise has too many dimensions for a rule"


def delay_consistency(scheme: Scheme, view: DelaySDAE) -> DelayConsistency:
    """Probe one step and two half steps of each size after the first delay.

    Parameters
    ----------
    scheme : Scheme
    view : DelaySDAE
        Of a pair that `no_delay_consistency` has nothing against.

    Returns
    -------
    DelayConsistency
    """
    step = OneStep(*linked(scheme, view))
    x, nodes = cloud(step.view, step.ito), half_steps(2 * view.noise_dim, NODES)
    h = LEVELS * step.view.time_unit
    with np.errstate(all="ignore"):
        found = [_level(step, x, nodes, float(size)) for size in h]
    rms, mean, scale = (np.stack(parts, axis=-1) for parts in zip(*found, strict=True))
    return DelayConsistency(h, rms, mean, scale)


def consistency_order(record: DelayConsistency) -> float:
    """Return the order p of Definition 3.1; infinite if the defects are rounding, NaN if they are not finite."""
    worst = record.scale.max(axis=0)
    of_rms, of_mean = (
        last_orders(record.h, part.max(axis=0), ROUNDING * worst, worst).order for part in (record.rms, record.mean)
    )
    return float(np.minimum(of_rms - 0.5, of_mean - 1.0))


def _level(step: OneStep, x: Array, nodes: HalfSteps, h: float) -> tuple[Array, Array, Array]:
    states, weights, t = x.shape[1], nodes.whole.weights, WHEN * step.view.horizon
    wide, d = np.repeat(x, len(weights), axis=1), len(x) // 2
    whole, first, second = (part.increment(h, states) for part in nodes)
    once, middle = step(wide, t, h, whole), step(wide, t, 0.5 * h, first)
    defects = (once - step(middle, t + 0.5 * h, 0.5 * h, second))[:d].reshape(d, states, -1)
    given_past, shares = _given_past(defects, weights, step.view.noise_dim // 2)
    scale = np.maximum(np.abs(x).max(axis=0), np.abs(once).max(axis=0).reshape(states, -1).max(axis=1))
    rms = np.sqrt(np.einsum("dsk,k->s", defects**2, weights))
    return rms, np.sqrt(np.einsum("dsk,k->s", given_past**2, shares)), scale


def _given_past(defects: Array, weights: Array, l: int) -> tuple[Array, Array]:
    """Return the means over the step's own noise at the nodes of the past, and the weights of these.

    Nodes are a product of 4 l rules: of the first half step, the l motions now and those one delay ago, and of the
    second one likewise.
    """
    count = round(len(weights) ** (1.0 / (4 * l)))
    shape, own = (count,) * (4 * l), (*range(l), *range(2 * l, 3 * l))
    full, products = weights.reshape(shape), (defects * weights).reshape(*defects.shape[:2], *shape)
    shares = full.sum(axis=own)
    means = products.sum(axis=tuple(axis + 2 for axis in own)) / shares
    return means.reshape(*defects.shape[:2], -1), shares.ravel()
