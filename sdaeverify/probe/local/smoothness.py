"""Whether an observable is smooth where runs go: what one step says of smooth functions is said of no other.

Local weak orders are about expectations of smooth functions. With a jump or a kink, the error of a law on few points
is that of a lattice: of order 1/2, or 1, whatever the order for smooth functions is.

Between two states the observable q is followed along a line. On intervals [a, b] that are halved towards where it
changes most,

    |q(b) - q(a)|                       falls with the length l of the interval, but not across a jump;
    |q(a) - 2 q((a + b)/2) + q(b)|/l    falls like l, but not across a kink.
"""

from collections.abc import Callable
from enum import StrEnum
from functools import lru_cache
from typing import Any

import numpy as np

from ...arrays import Array
from ...forms import Problem
from ...numerics.statistics import EPS
from ..step.nodes import SEED
from ..step.states import reached_states

# Lines between states, and intervals that each is cut into at first.
LINES, CUTS = 64, 32
# Halvings towards a jump, and towards a kink, of which the last ones tell whether anything falls. A difference of
# order l^2 is rounding after more of them.
HALVINGS, LAST = {1: 36, 2: 14}, 6
# What falls like a power l^r, r < 1/2, is taken for what does not fall.
FALLS = 2.0 ** (-0.5 * LAST)
# A jump, or the change of a slope, is told from a part of the observable's change on the line on, above rounding.
SMALL, ROUNDINGS = 1e-6, 64.0


class Smoothness(StrEnum):
    """What an observable is where runs go."""

    SMOOTH = "smooth"
    KINK = "a kink"
    JUMP = "a jump"


@lru_cache(maxsize=256)
def smoothness(view: Problem, observable: str) -> Smoothness:
    """Return whether an observable has jumps or kinks at the final time between states that solutions reach.

    Parameters
    ----------
    view : Problem
    observable : str
    """
    value, states = _in_states(view, observable)
    rng = np.random.Generator(np.random.Philox(key=SEED + 12))
    ends = states[:, rng.integers(states.shape[1], size=(2, LINES))]
    with np.errstate(all="ignore"):
        if _persists(lambda s: value(_on_lines(ends, s)), 1):
            return Smoothness.JUMP
        return Smoothness.KINK if _persists(lambda s: value(_on_lines(ends, s)), 2) else Smoothness.SMOOTH


def _in_states(view: Any, observable: str) -> tuple[Callable[[Array], Array], Array]:
    """Return the observable as a function of states of shape (d, P), and states that solutions reach."""
    ito, start = view.ito(), view.parts(view.initial(1))
    sizes = {name: len(part) for name, part in start.items()}
    ends = np.cumsum(list(sizes.values()))

    def parts(x: Array) -> dict[str, Array]:
        if ito is not None:
            return dict(ito.parts(x))
        return {name: x[end - sizes[name] : end] for name, end in zip(sizes, ends, strict=True)}

    def value(x: Array) -> Array:
        found = view.observables[observable](view.horizon, parts(x))
        return np.asarray(np.broadcast_to(np.asarray(found, dtype=float), x.shape[1:]))

    if ito is not None:
        return value, reached_states(view, ito).points
    x = np.concatenate(list(start.values()))
    rng = np.random.Generator(np.random.Philox(key=SEED + 13))
    return value, x + (1.0 + np.abs(x)) * rng.standard_normal((len(x), LINES))


def _on_lines(ends: Array, s: Array) -> Array:
    """Return points at s, shape (N, LINES), of the lines, one after the other: shape (d, N LINES)."""
    first, second = ends[:, 0, None], ends[:, 1, None]
    return np.asarray((first + s * (second - first)).reshape(len(ends), -1))


def _persists(q: Callable[[Array], Array], order: int) -> bool:
    """Tell whether differences of the first or second order do not fall with the interval, on some line."""

    def differences(left: Array, length: float) -> Array:
        at = left + length * np.linspace(0.0, 1.0, order + 1)[:, None, None]
        values = q(at.reshape(-1, LINES)).reshape(order + 1, -1, LINES)
        return np.asarray(np.abs(np.diff(values, order, axis=0)[0]) / length ** (order - 1))

    length, left = 1.0 / CUTS, np.repeat(np.arange(CUTS)[:, None] / CUTS, LINES, axis=1)
    values = q(left).reshape(CUTS, LINES)
    span, size = np.ptp(values, axis=0), np.abs(values).max(axis=0)
    followed = []
    for _ in range(HALVINGS[order] + 1):
        found = np.nan_to_num(differences(left, length), nan=0.0, posinf=0.0)
        at = found.argmax(axis=0)
        followed.append(found.max(axis=0))
        left = left[at, np.arange(LINES)] + 0.5 * length * np.array([0.0, 0.5, 1.0])[:, None]
        length *= 0.5
    before, last = followed[-1 - LAST], followed[-1]
    seen = last > np.maximum(SMALL * span, ROUNDINGS * EPS * size / (2.0 * length) ** (order - 1))
    return bool((seen & (last > FALLS * before)).any())
