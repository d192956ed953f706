"""Semi-stability: the growth rate of the mean of V = 1 + |x|_*^4 in one step, at states near and far.

With rho(h) = sup_x log(E V(Phi(x, h, w)) / V(x)) / h, iterating a step gives

    E V(X_k) <= exp(rho(h) t_k) E V(X_0),

so moments are bounded uniformly in h if rho(h) is (Lindner & Stroot 2017, Definition 4.7 and Lemma 4.12).
This is sufficient for bounded moments, and verifies a claim of them. It is not necessary. Claims of orders in mean
square are left open if a run after rare noise shows that moments diverge.
"""

from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array, Parts, Problem, Scheme
from sdaeverify.probing import Nodes, OneStep, extreme_states, step_nodes

POWER = 4
# Step sizes 4^-2, ..., 4^-8 of the horizon, or of the unit of time if that is shorter.
LEVELS = 4.0 ** -np.arange(2.0, 9.0)
# Largest number of normals with a tensor rule. For more, the rule is two points +-sqrt(n) on each axis, exact up to
# degree 3; the contribution of higher degrees in V is of order h^2.
FEW, NODES = 3, (6, 6, 4)


class Growth(NamedTuple):
    """Growth rates of the mean of V in one step.

    Attributes
    ----------
    h : ndarray, shape (H,)
        Coarsest first.
    rate : ndarray, shape (H,)
        Maximum over the states; infinite if a step has no root or V has no finite mean.
    far : ndarray, shape (H,)
        V^(1/4) of the state with the maximum.
    states : ndarray, shape ()
        Number of states.
    """

    h: Array
    rate: Array
    far: Array
    states: Array


def lyapunov(problem: Problem, parts: Parts) -> Array:
    """Return V = 1 + |x|_*^4, shape (P,), in the norm of the problem."""
    return np.asarray(1.0 + problem.squared_norm(parts) ** (POWER / 2))


def growth(scheme: Scheme, view: Any) -> Growth:
    """Return the growth rates for a pair whose map can be probed, see `OneStep.why_not_probed`."""
    step = OneStep(scheme, view)
    x, h = extreme_states(view, step.equation), LEVELS * step.time_unit
    nodes = _nodes(scheme, view.noise_dim)
    before = lyapunov(view, view.parts(view.state(x)))
    with np.errstate(all="ignore"):
        rates = np.array([_rates(step, x, nodes, before, float(size)) for size in h])
    far = before[rates.argmax(axis=1)] ** (1.0 / POWER)
    return Growth(h, rates.max(axis=1), far, np.array(float(x.shape[1])))


def _rates(step: OneStep, x: Array, nodes: Nodes, before: Array, h: float) -> Array:
    view: Any = step.view
    t, count = step.time, len(nodes.weights)
    wide = np.repeat(x, count, axis=1)
    result = step.make(wide, t, h, nodes.increment(h, x.shape[1]))
    V = lyapunov(view, view.parts(view.state(step.read(result.state))))
    bad = ~np.isfinite(V) if result.failed is None else result.failed | ~np.isfinite(V)
    mean = nodes.mean(np.where(bad, np.inf, V).reshape(-1, count))
    return np.log(mean / before) / h


def _nodes(scheme: Scheme, motions: int) -> Nodes:
    areas = "H" in scheme.noise
    count = motions * (1 + areas)
    if count <= FEW:
        return step_nodes(motions, NODES[count - 1], areas=areas, law=scheme.law)
    axes = np.sqrt(count) * np.concatenate([np.eye(count), -np.eye(count)], axis=1)
    H = axes[motions:] / np.sqrt(12.0) if areas else None
    return Nodes(axes[:motions], H, np.full(2 * count, 0.5 / count))
