"""How much one step of a variant differs from one of its original: what is really wrong, without any verdict.

If the original has strong order p, and the difference D of one step has a root mean square of order p + 1/2 and a
mean of order p + 1 in h, the variant has order p as well (Milstein & Tretyakov 2004, Theorem 1.1). A difference of
lower order is an error of lower order. For weak orders the means of observables have to agree to order p + 1.
"""

from collections.abc import Callable
from contextlib import suppress
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array, Increment, Scheme

FINEST, COARSEST = 11, 5
STATES, WALK = 6, 48
NODES = {1: 12, 2: 8, 3: 5, 4: 4}
# Below this part of the states a difference is rounding.
ROUNDING = 1e-12


class Orders(NamedTuple):
    """Orders that are left to a variant, by quantity; infinite where it differs by rounding.

    Attributes
    ----------
    strong : dict of str to float
        By component.
    weak : dict of str to float
        By observable.
    """

    strong: dict[str, float]
    weak: dict[str, float]

    @property
    def same(self) -> bool:
        """Whether all differences are rounding."""
        return all(np.isinf(order) for order in (*self.strong.values(), *self.weak.values()))


def orders(original: Scheme, variant: Scheme, view: Any, when: float = 0.25) -> Orders:
    """Return the orders that the differences of one step leave.

    Parameters
    ----------
    original, variant : Scheme
    view : Problem
        Of their form.
    when : float
        Part of the horizon at which steps are compared.
    """
    sizes = [view.horizon * 2.0**-k for k in range(COARSEST, FINEST + 1)]
    cloud = _cloud(original, view, when)
    found = [_defects(original, variant, view, cloud, h, when * view.horizon) for h in sizes]
    components, observables = found[0][0], found[0][2]
    strong = {
        name: min(
            _slope(sizes, [f[0][name] for f in found]) - 0.5,
            _slope(sizes, [f[1][name] for f in found]) - 1.0,
        )
        for name in components
    }
    weak = {name: _slope(sizes, [f[2][name] for f in found]) - 1.0 for name in observables}
    return Orders(strong, weak)


def _slope(sizes: list[float], values: list[float]) -> float:
    kept = [(np.log2(h), np.log2(value)) for h, value in zip(sizes, values, strict=True) if value > 0.0]
    if len(kept) < 3:
        return float("inf") if not any(values) else float("nan")
    x, y = np.array(kept[-4:]).T
    return float(np.polyfit(x, y, 1)[0])


def _nodes(dimension: int) -> tuple[Array, Array]:
    count = NODES.get(dimension, 3)
    points, weights = np.polynomial.hermite_e.hermegauss(count)
    weights = weights / weights.sum()
    grid = np.array(list(product(points, repeat=dimension))).T
    return grid, np.array([np.prod(w) for w in product(weights, repeat=dimension)])


def _dimension(view: Any) -> tuple[int, int, int]:
    """Return how many normals a step has: in dW, in H, and in the past's increment."""
    areas = view.noise_dim if "H" in view.noise else 0
    return view.noise_dim, areas, len(view.past(0.0)) if getattr(view, "delay", 0.0) else 0


def _increment(view: Any, xi: Array, h: float, past: Array | None) -> Increment:
    l, areas, _ = _dimension(view)
    noise = Increment(np.sqrt(h) * xi[:l], np.sqrt(h / 12.0) * xi[l : l + areas] if areas else None)
    if past is None:
        return noise
    return noise._replace(lagged=past, ahead=past + np.sqrt(h) * xi[l + areas :])


def _cloud(scheme: Scheme, view: Any, when: float) -> Any:
    """Return states of a run up to part `when` of the horizon, as the problem's."""
    rng = np.random.default_rng(7)
    h = view.horizon * when / WALK
    state, step, total = scheme.start(view, STATES, h), scheme.prepare(view, h), sum(_dimension(view))
    for k in range(WALK):
        past = view.initial(STATES).x if _dimension(view)[2] else None
        noise = _increment(view, rng.standard_normal((total, STATES)), h, past)
        state = step(state, k * h, scheme.law.increment(noise, h)).state
    return state


def _defects(original: Scheme, variant: Scheme, view: Any, cloud: Any, h: float, t: float) -> tuple[Any, Any, Any]:
    total = sum(_dimension(view))
    grid, weights = _nodes(total)
    count = len(weights)
    xi = np.tile(grid, STATES)
    state = _each(cloud, lambda part: np.repeat(part, count, axis=1))
    past = None
    if _dimension(view)[2]:
        past = np.repeat(view.initial(STATES).x + 0.1 * np.arange(1.0, STATES + 1.0), count, axis=1)
    noise = original.law.increment(_increment(view, xi, h, past), h)
    with np.errstate(all="ignore"):
        new = [scheme.prepare(view, h)(state, t, noise).state for scheme in (original, variant)]
    right, wrong = (original.parts(view, state) for state in new)
    strong = {name: _moments(wrong[name] - right[name], right[name], weights) for name in right}
    seen = _seen(view, right)
    means = {name: _mean(seen[name](t + h, wrong), seen[name](t + h, right), weights) for name in seen}
    return {n: m[0] for n, m in strong.items()}, {n: m[1] for n, m in strong.items()}, means


def _seen(view: Any, parts: Any) -> dict[str, Callable[..., Array]]:
    """Return the observables of what the scheme has; a multiplier, for one, is not everybody's."""
    found = {}
    for name, observable in view.observables.items():
        with suppress(KeyError):
            observable(0.0, parts)
            found[name] = observable
    return found


def _moments(difference: Array, size: Array, weights: Array) -> tuple[float, float]:
    by_state = difference.reshape(len(difference), STATES, -1)
    floor = ROUNDING * (np.abs(size).max() + 1e-300)
    rms = float(np.sqrt(((by_state**2) @ weights).max(initial=0.0)))
    mean = float(np.abs(by_state @ weights).max(initial=0.0))
    return (rms if rms > floor else 0.0), (mean if mean > floor else 0.0)


def _mean(wrong: Array, right: Array, weights: Array) -> float:
    by_state = np.broadcast_to(wrong - right, (STATES * len(weights),)).reshape(STATES, -1)
    mean = float(np.abs(by_state @ weights).max())
    return mean if mean > ROUNDING * (np.abs(right).max() + 1.0) else 0.0


def _each(state: Any, change: Callable[[Array], Array]) -> Any:
    return type(state)(*map(change, state)) if isinstance(state, tuple) else change(state)
