"""The times at which a one-step map is probed: one, and others at which it goes elsewhere.

Where neither equation nor scheme depend on time, one time is as good as any. A step that is wrong from some time on,
or right at one time only, is not seen there; that it does not go to the same place at another time is. Steps are made
at a random time in each of 32 parts of the horizon, so that none is left out, and those are taken that are least like
the ones taken before: by where they go beside Euler's step, or by where they go at all. Nor is a step
seen that is wrong at some of its indices n = t/h, wherever these lie: among so many steps in a row, that it is unlike
its neighbours is seen.

First and last steps of a run may differ from all others: a single error of a step's size is no loss of order.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Problem, components
from ...noise.brownian import Increment
from .nodes import SEED
from .one_step import OneStep
from .states import WHEN, cloud
from .together import PathBatch, together

# Parts of the horizon with a time in each of them, and times that are taken beside the first.
# Size: times.
STRATA, FURTHER = 32, 2
# Of the unit of time: at whole numbers of it, fine steps of all sizes have indices of the same remainders.
WHOLE, FINE, FEWEST = 2.0**-5, 2.0**-7, 2.0
# Of the unit of time.
H = 2.0**-6
# A step that depends on time moves by more than this part of the states.
SAME = 1e-9
# Steps in a row that are compared with their neighbours, from one in so many states.
# Size: steps in a row.
ROW, EVERY = 128, 4
# Steps of a larger system than this take long: a row is as short as this, and a rarer fault than that is not seen.
# Size: steps in a row of large systems.
LARGE, SHORT_ROW = 32, 16
# Second differences in time that are so many times those of the equation are none of its own.
UNLIKE = 8.0
DIFFERENT = "its steps are not the same at all times"
ALIKE = 0.9


class ProbeTime(NamedTuple):
    """When steps of every size are probed.

    Attributes
    ----------
    t : float
        The time; of a row of steps, where it begins.
    place : int or None
        In a row: 0 for the step, of any size, that is least like its neighbours, 1 for the one after it.
    """

    t: float
    place: int | None = None

    def of_size(self, step: OneStep, h: float) -> float:
        """Return the time of the step of size h."""
        if self.place is None:
            return self.t
        found = _row(step, h, self.t)
        return found.odd + self.place * h if len(found.t) else self.t


def first_time(horizon: float) -> float:
    """Return the time nearest to a fifth of a horizon that is a whole number of fine steps of all sizes.

    Steps of a run begin at such times, and a step may make its index of its time, as int(t/h).

    Parameters
    ----------
    horizon : float
    """
    step = FINE * min(1.0, horizon)
    return step * round(WHEN * horizon / step)


class _Row(NamedTuple):
    # Times of steps with two neighbours, how far each is from their mean, and from that of the equation.
    t: Array
    bend: Array
    off: Array

    @property
    def odd(self) -> float:
        # Of steps that are alike, one in two, say, the same kind is taken at all sizes.
        return float(self.t[np.where(self.bend >= ALIKE * self.bend.max(), self.off, -1.0).argmax()])


def times(step: OneStep, x: Array) -> tuple[ProbeTime, ...]:
    """Return when a step is probed.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S)
        States of the cloud.

    Returns
    -------
    tuple of ProbeTime
        About 0.2 of the horizon; up to two of 32 times at which the same noise leads elsewhere, least like the
        others; the step least like its neighbours and the next one, if one in a row is unlike them.
    """
    fixed, odd = _fixed_times(step, np.asarray(x, dtype=float).tobytes()), odd_step(step)
    return (*fixed, *(() if odd is None else (ProbeTime(odd, 0), ProbeTime(odd, 1))))


# Orders on paths and in law are asked of the same states.
@lru_cache(maxsize=8)
def _fixed_times(step: OneStep, states: bytes) -> tuple[ProbeTime, ...]:
    x = np.frombuffer(states).reshape(step.equation.dimension, -1)
    h, t = H * step.time_unit, strata(step.view.horizon)
    batches = [PathBatch(x, at, h, _noise(step, h, x.shape[1])) for at in t]
    with np.errstate(all="ignore"):
        there = np.array([step.read(made.state) for made in step.together(batches)])
        size = SAME * np.abs(there[0]).max(where=np.isfinite(there[0]), initial=0.0)
        chosen = [0]
        if not all(np.allclose(new, there[0], rtol=SAME, atol=size, equal_nan=True) for new in there[1:]):
            beside = there - np.array([*together(step.euler, batches)])
            chosen = _unlike(_unlike(chosen, beside, size), there, size)
    return tuple(ProbeTime(t[place]) for place in chosen)


def strata(horizon: float) -> tuple[float, ...]:
    """Return 0.2 of a horizon, and a random time in each of its parts, whole numbers of steps from begin and end."""
    parts = np.arange(STRATA) + np.random.Generator(np.random.Philox(key=SEED + 8)).uniform(size=STRATA)
    step = WHOLE * min(1.0, horizon)
    found = step * np.clip(np.round(horizon * parts / (STRATA * step)), FEWEST, np.ceil(horizon / step) - 1.0)
    return (first_time(horizon), *dict.fromkeys(found.tolist()))


def _unlike(chosen: list[int], values: Array, size: float) -> list[int]:
    """Add places, up to two beside the first, whose values are farthest from all chosen ones and beyond a size."""
    flat = np.nan_to_num(values.reshape(len(values), -1), posinf=0.0, neginf=0.0)
    while len(chosen) <= FURTHER:
        far = np.min([np.abs(flat - flat[place]).max(axis=1) for place in chosen], axis=0)
        if not far.max() > size:
            break
        chosen = [*chosen, int(far.argmax())]
    return chosen


def in_a_row(view: Problem) -> int:
    """Return how many steps in a row are made to find those that are unlike the others."""
    return ROW if components(view) <= LARGE else SHORT_ROW


def changing(step: OneStep) -> str:
    """Return that one step is not that of all times, on an equation whose coefficients are, or an empty string."""
    return DIFFERENT if len(times(step, cloud(step.view, step.equation))) > 1 else ""


def odd_step(step: OneStep) -> float | None:
    """Return when a step in a row is unlike its neighbours, and not because the equation is; None if no step is."""
    found = _first_row(step)
    return found.odd if (found.bend > 0.0).any() else None


# The schemes of a problem are tried one after the other, and probed when all have been.
@lru_cache(maxsize=64)
def _first_row(step: OneStep) -> _Row:
    h = (1.0 - WHEN) / in_a_row(step.view)
    return _row(step, h * step.time_unit, step.time)


def _row(step: OneStep, h: float, begin: float) -> _Row:
    """Return how far the steps of a row go from the mean of where their neighbours go, with the same noise.

    What rounding and the equation explain is nothing.
    """
    x = cloud(step.view, step.equation)[:, ::EVERY]
    # The row ends before the last step.
    first, last = int(begin / h), round(step.view.horizon / h) - 1
    t = h * np.arange(first, min(first + in_a_row(step.view), last))
    noise = _noise(step, h, x.shape[1])
    batches = [PathBatch(x, at, h, noise) for at in t.tolist()]
    with np.errstate(all="ignore"):
        there = np.array([step.read(made.state) for made in step.together(batches)])
        bend, allowed = _bend(there), SAME * np.abs(there).max(where=np.isfinite(there), initial=0.0)
        if not (bend > allowed).any():
            return _Row(t[1:-1], np.zeros_like(bend), bend)
        equation = np.array([*together(step.euler, batches)])
        allowed += UNLIKE * _bend(equation).max(initial=0.0)
        off = np.nan_to_num(np.abs(there - equation).reshape(len(t), -1)).max(axis=1)
        return _Row(t[1:-1], np.where(bend > allowed, bend, 0.0), off[1:-1])


def _bend(values: Array) -> Array:
    """Return the largest second differences along the first axis; those that are not finite are none."""
    if len(values) < 3:
        return np.zeros(0)
    second = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2]).reshape(len(values) - 2, -1)
    return np.asarray(second.max(axis=1, where=np.isfinite(second), initial=0.0))


def _noise(step: OneStep, h: float, paths: int) -> Increment:
    rng = np.random.Generator(np.random.Philox(key=SEED + 3))
    return step.scheme.law.increment(step.view.drawn(rng, h, paths), h)
