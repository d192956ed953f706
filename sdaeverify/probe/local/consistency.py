"""Consistency of one step: whether it follows the equation, with any order.

A scheme is consistent if h^{-1/2} ||d||_{L2} and h^{-1} |E d| tend to 0 for d = Phi_h(x; dW) - [x + f h + B dW]
(Lindner & Stroot 2017, Definition 4.7). If it is also semi-stable it converges, without a rate. Otherwise it may
converge to the solution of another equation, with any order of its own differences. `step_law` decides this, for all
probes of one step.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Delayed, Problem
from ..step.nodes import HalfSteps, half_steps, product_rule
from ..step.one_step import OneStep
from ..step.states import cloud
from .delay_links import remove_delay
from .equation_rates import rates_at
from .orders import worst_order
from .reach import reach
from .step_law import MOMENTS, StepLaw, compare_at, step_law
from .strong_defects import LEVELS


class Consistency(NamedTuple):
    """Deviation of short steps from the equation by component, pure outputs included; see `step_law`.

    Attributes
    ----------
    off : ndarray, shape (C,)
        Largest deviation with a nonzero limit of a component, or of one whose errors affect it, relative to the
        motion of that one; 0 if there is none.
    moment, row : ndarray, shape (C,)
        Moment and component of that deviation.
    at : ndarray, shape (C,)
        Number of compared points (t, x) with a deviation.
    points : ndarray, shape ()
        Number of compared points.
    """

    off: Array
    moment: Array
    row: Array
    at: Array
    points: Array

    def departure(self, names: Sequence[str], component: int | None = None) -> str:
        """Return the deviation of a component in one line, or an empty string if there is none.

        Parameters
        ----------
        names : sequence of str
            Names of the C components.
        component : int, optional
            Its index; the full state if omitted.
        """
        place = int(self.off.argmax()) if component is None else component
        if not self.off[place] > 0.0:
            return ""
        moment, hint = MOMENTS[int(self.moment[place])]
        off = f"off by {self.off[place]:.2g} of the motion of {names[int(self.row[place])]} at any h"
        return f"the {moment} of one step is {off}, at {self.at[place]:.0f} of {self.points:.0f} points{hint}"


def consistency(scheme: Scheme, view: Problem) -> Consistency | None:
    """Return the deviation of short steps from the equation; None if they cannot be compared.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form, without delay; see `remove_delay`.
    """
    law, step = step_law(scheme, view), OneStep(scheme, view)
    return None if law is None or not law.points else _of_law(law, step)


def consistency_at(step: OneStep, x: Array) -> Consistency | None:
    """Return the deviation of short steps from given states, shape (d, S), at a fifth of the horizon."""
    rates = rates_at(step.view, step.equation, np.array([step.time]), x[None])
    law = compare_at(step, rates)
    return None if law is None or not law.points else _of_law(law, step)


def _of_law(law: StepLaw, step: OneStep) -> Consistency:
    """Return the deviations of a comparison, each with those of the components whose errors affect it."""
    off, count = np.where(law.wrong, law.off, 0.0), len(law.rows)
    affects = reach(step, cloud(step.view, step.equation)) > 0.0 if off.any() else np.eye(count, dtype=bool)
    found = []
    for among in affects:
        own = np.where(among[:, None], off, 0.0)
        moment, row, place = np.unravel_index(own.argmax(), own.shape)
        found.append((own[moment, row, place], moment, row, (own > 0.0).any(axis=(0, 1)).sum()))
    largest, moments, rows, counts = (np.array(column, dtype=float) for column in zip(*found, strict=True))
    return Consistency(largest, moments, rows, counts, np.array(float(law.points)))


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
    given_past, shares = average_given_past(defects, weights, step.view.noise_dim // 2)
    scale = np.maximum(np.abs(x).max(axis=0), np.abs(once).max(axis=0).reshape(states, -1).max(axis=1))
    rms = np.sqrt(np.einsum("dsk,k->s", defects**2, weights))
    return rms, np.sqrt(np.einsum("dsk,k->s", given_past**2, shares)), scale


def average_given_past(defects: Array, weights: Array, l: int) -> tuple[Array, Array]:
    """Return the means over the step's current noise at the nodes of the past, and the weights of these nodes.

    Nodes are a product of 4 l rules: of the first half step, for the l current motions and those one delay ago, and
    of the second half step in the same way.

    Parameters
    ----------
    defects : ndarray, shape (d, S, K)
        At all nodes.
    weights : ndarray, shape (K,)
    l : int

    Returns
    -------
    means : ndarray, shape (d, S, sqrt(K))
    shares : ndarray, shape (sqrt(K),)
    """
    count = round(len(weights) ** (1.0 / (4 * l)))
    shape, own = (count,) * (4 * l), (*range(l), *range(2 * l, 3 * l))
    full, products = weights.reshape(shape), (defects * weights).reshape(*defects.shape[:2], *shape)
    shares = full.sum(axis=own)
    means = products.sum(axis=tuple(axis + 2 for axis in own)) / shares
    return means.reshape(*defects.shape[:2], -1), shares.ravel()
