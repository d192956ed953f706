"""The local strong order of a scheme in a few lines, independent of what the program makes of it."""

from typing import NamedTuple

import numpy as np

from facade import half_steps
from sdaeverify import Array, Problem, Scheme
from sdaeverify.probing import OneStep, cloud

STEPS = 4.0 ** -np.arange(3, 8)
FLOOR = 6e-14


class Order(NamedTuple):
    """The order p = min(p2 - 1/2, p1 - 1), and whether the step is consistent with Ito's equation."""

    order: float
    consistent: bool


def strong_order(scheme: Scheme, view: Problem, x: Array | None = None) -> Order:
    """Compare a step with two half steps and with Euler-Maruyama, at six Gauss-Hermite nodes a variable."""
    one = OneStep(scheme, view)
    x = cloud(view, one.equation) if x is None else x
    nodes = half_steps(view.noise_dim, 6, areas="H" in scheme.noise)
    states, count = x.shape[1], len(nodes.whole.weights)
    xx, t = np.repeat(x, count, axis=1), 0.2 * view.horizon
    sizes = []
    for h in STEPS:
        whole = nodes.whole.increment(h, states)
        state = one.advance(one.enter(xx, t, h / 2), t, h / 2, nodes.first.increment(h, states))
        twice = one.read(one.advance(state, t + h / 2, h / 2, nodes.second.increment(h, states)))
        once = one(xx, t, h, whole)
        for defect in (once - twice, once - one.euler(xx, t, h, whole)):
            parts = defect.reshape(len(x), states, count)
            sizes.append(np.sqrt(nodes.whole.mean((parts**2).sum(axis=0)).max()))
            sizes.append(np.abs(nodes.whole.mean(parts)).max())
    p2, p1, q2, q1 = (slope(size, np.abs(x).max()) for size in np.reshape(sizes, (len(STEPS), 4)).T)
    return Order(min(p2 - 0.5, p1 - 1.0), q2 > 0.9 and q1 > 1.4)


def slope(size: Array, scale: float) -> float:
    """Return the order between the two smallest step sizes above rounding, infinite if there are no two."""
    seen = np.flatnonzero(size > FLOOR * scale)
    return float(np.log(size[seen[-2]] / size[seen[-1]]) / np.log(4.0)) if len(seen) > 1 else np.inf
