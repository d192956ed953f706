"""Times at which a one-step map is probed: a fixed one, and others at which its steps are different.

If neither equation nor scheme depend on time, one time suffices. It would not show a step that is wrong from some
time on, or right at one time only, but such a step gives different results at different times. Steps are made at a
random time in each of 32 parts of the horizon, from the states of `cloud` and from reached ones, since a step may be
wrong in a region of states only. The times whose steps differ most from those already selected are probed: by their
difference from Euler's step, or by the step itself. A step may also be wrong at some of its indices n = t/h only.
Among many successive steps it is found by its difference from its neighbours.

First and last steps of a run are not compared: a single error of the size of a step does not reduce an order.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...forms import Problem, components
from ...numerics.newton import SOLVED
from .nodes import SEED
from .one_step import OneStep
from .states import WHEN, cloud, spread_states
from .together import PathBatch, together

# Parts of the horizon with a time in each of them, and the number of times selected in addition to the first.
# Size: times.
STRATA, FURTHER = 32, 2
# In units of time: at multiples of it, the indices of fine steps of all sizes have the same remainders.
# Size: distances of times.
WHOLE, FINE, FEWEST = 2.0**-5, 2.0**-7, 2.0
# In units of time.
# Size: of a step.
H = 2.0**-6
# Size: of a long step, in units of time; a step that accepts or rejects a proposal rejects few short ones.
LONG = 1.0
# Number of successive steps that are compared with their neighbours.
# Size: steps in a row.
ROW = 128
# Steps of a system larger than the first take long: only this number of them is made, and rarer faults are missed.
# Size: steps in a row of large systems.
LARGE, SHORT_ROW = 32, 16
# Second differences in time of up to this multiple of those of the equation are attributed to the equation.
# Theorem: elementary, of x + h sum_i b_i f(t + c_i h) they are at most sum_i |b_i| times those of x + h f(t):
# right for weights that add up to no more than 8.
UNLIKE = 8.0
DIFFERENT = "its steps depend on the time at which they are made"
# Times after the horizon, and the latest one in horizons: chains and powers of a step go beyond the horizon.
# Size: times; what begins later than 1024 horizons is not seen.
LATE, LATEST = 32, 10.0
# Size: of what is selected among steps that differ from their neighbours.
ALIKE = 0.9


class ProbeTime(NamedTuple):
    """Time at which steps of every size are probed.

    Attributes
    ----------
    t : float
        The time; for successive steps, the time from which they are searched.
    place : int or None
        For successive steps: 0 for the step, of any size, that differs most from its neighbours, 1 for the next one.
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
    """Return the time nearest to a fifth of the horizon that is a multiple of fine steps of all sizes.

    Steps of a run begin at such times, and a step may compute its index from its time, as int(t/h).

    Parameters
    ----------
    horizon : float
    """
    step = FINE * min(1.0, horizon)
    return step * round(WHEN * horizon / step)


class _Row(NamedTuple):
    # Times of steps with two neighbours, their distances from the mean of these, and from Euler's step.
    t: Array
    bend: Array
    off: Array

    @property
    def odd(self) -> float:
        # If every second step is different, for example, a step of the same kind is selected at all sizes.
        return float(self.t[np.where(self.bend >= ALIKE * self.bend.max(), self.off, -1.0).argmax()])


def times(step: OneStep, x: Array) -> tuple[ProbeTime, ...]:
    """Return the times at which a step is probed.

    Parameters
    ----------
    step : OneStep
    x : ndarray, shape (d, S)
        States of `cloud`.

    Returns
    -------
    tuple of ProbeTime
        About 0.2 of the horizon; up to two of 32 times at which the same noise gives the most different results; and,
        if one of many successive steps differs from its neighbours, the times of that step and of the next one.
    """
    fixed, odd = _fixed_times(step, np.asarray(x, dtype=float).tobytes()), odd_step(step)
    return (*fixed, *(() if odd is None else (ProbeTime(odd, 0), ProbeTime(odd, 1))))


# Cached, because strong and weak orders are probed at the same states.
@lru_cache(maxsize=8)
def _fixed_times(step: OneStep, states: bytes) -> tuple[ProbeTime, ...]:
    x = np.frombuffer(states).reshape(step.equation.dimension, -1)
    x = np.concatenate([x, spread_states(step.view, step.equation)], axis=1)
    h, t = H * step.time_unit, strata(step.view.horizon)
    with np.errstate(all="ignore"):
        batches, there = _steps_at(step, x, h, t)
        chosen = [0]
        if _differ(there).any():
            size, beside = _rounding(there[0]), there - np.array([*together(step.euler, batches)])
            chosen = _unlike(_unlike(chosen, beside, size), there, size)
    return tuple(ProbeTime(t[place]) for place in chosen)


def strata(horizon: float) -> tuple[float, ...]:
    """Return 0.2 of the horizon, and a random multiple of `WHOLE` in each of its parts, away from both ends."""
    parts = np.arange(STRATA) + np.random.Generator(np.random.Philox(key=SEED + 8)).uniform(size=STRATA)
    step = WHOLE * min(1.0, horizon)
    found = step * np.clip(np.round(horizon * parts / (STRATA * step)), FEWEST, np.ceil(horizon / step) - 1.0)
    return (first_time(horizon), *dict.fromkeys(found.tolist()))


def _unlike(chosen: list[int], values: Array, size: float) -> list[int]:
    """Append up to two indices of the values that differ most from all chosen ones, by more than `size`."""
    flat = np.nan_to_num(values.reshape(len(values), -1), posinf=0.0, neginf=0.0)
    while len(chosen) <= FURTHER:
        far = np.min([np.abs(flat - flat[place]).max(axis=1) for place in chosen], axis=0)
        if not far.max() > size:
            break
        # The middle of the times with the same steps: shorter steps from the first one may precede the difference.
        farthest = flat[far.argmax()]
        same = np.flatnonzero(np.abs(flat - farthest).max(axis=1) <= size)
        chosen = [*chosen, int(same[len(same) // 2])]
    return chosen


def in_a_row(view: Problem) -> int:
    """Return the number of successive steps that are made to find a step that differs from the others."""
    return ROW if components(view) <= LARGE else SHORT_ROW


def changing(step: OneStep) -> str:
    """Return that steps depend on time, although the coefficients of the equation do not, or an empty string."""
    return DIFFERENT if len(times(step, cloud(step.view, step.equation))) > 1 else ""


class LateChange(NamedTuple):
    """Two times at which steps with the same noise differ, although the equation does not depend on time.

    Attributes
    ----------
    early, late : float
        A time in the horizon, and the first one after it with a different step; NaN if all steps are equal.
    """

    early: float
    late: float


def late_change(step: OneStep) -> LateChange:
    """Compare steps after the horizon with one in it, from the same states with the same noise.

    A stationary law and mean-square stability are about all times, and one step stands for all of them. The times
    after the horizon are random, with uniform logarithms; steps are short and long.

    Parameters
    ----------
    step : OneStep
        States must be comparable.

    Returns
    -------
    LateChange
        Without a late time also if the equation itself changes.
    """
    x = spread_states(step.view, step.equation)
    drawn = np.random.Generator(np.random.Philox(key=SEED + 8)).uniform(0.0, LATEST, LATE)
    t = [step.time, *(step.view.horizon * np.exp2(np.sort(drawn))).tolist()]
    with np.errstate(all="ignore"):
        unlike = np.zeros(LATE, dtype=bool)
        for h in (H * step.time_unit, LONG * step.time_unit):
            batches, there = _steps_at(step, x, h, t)
            found = _differ(there)
            if found.any():
                unlike |= found & ~_differ(np.array([*together(step.euler, batches)]))
    return LateChange(t[0], t[1 + int(unlike.argmax())] if unlike.any() else np.nan)


def _differ(values: Array) -> Array:
    """Return which values along the first axis differ from the first one by more than rounding."""
    same = np.isclose(values[1:], values[0], rtol=SOLVED, atol=_rounding(values[0]), equal_nan=True)
    return np.asarray(~same.all(axis=(1, 2)))


def _rounding(values: Array) -> float:
    """Return the tolerance of a solver for values of this size."""
    return float(SOLVED * np.abs(values).max(where=np.isfinite(values), initial=0.0))


def odd_step(step: OneStep) -> float | None:
    """Return the time of a step that differs from its neighbours beyond the equation's own change, or None."""
    found = _first_row(step)
    return found.odd if (found.bend > 0.0).any() else None


# Cached: all schemes of a problem are checked one after the other before they are probed.
@lru_cache(maxsize=64)
def _first_row(step: OneStep) -> _Row:
    h = (1.0 - WHEN) / in_a_row(step.view)
    return _row(step, h * step.time_unit, step.time)


def _row(step: OneStep, h: float, begin: float) -> _Row:
    """Return the distances of successive steps from the mean of their neighbours, with the same noise.

    Distances that rounding and the equation explain are set to 0.
    """
    x = spread_states(step.view, step.equation)
    # The last step of the run is left out.
    first, last = int(begin / h), round(step.view.horizon / h) - 1
    t = h * np.arange(first, min(first + in_a_row(step.view), last))
    with np.errstate(all="ignore"):
        batches, there = _steps_at(step, x, h, t.tolist())
        bend, allowed = _bend(there), _rounding(there)
        if not (bend > allowed).any():
            return _Row(t[1:-1], np.zeros_like(bend), bend)
        equation = np.array([*together(step.euler, batches)])
        allowed += UNLIKE * _bend(equation).max(initial=0.0)
        off = np.nan_to_num(np.abs(there - equation).reshape(len(t), -1)).max(axis=1)
        return _Row(t[1:-1], np.where(bend > allowed, bend, 0.0), off[1:-1])


def _bend(values: Array) -> Array:
    """Return the largest second differences along the first axis, shape (n - 2,); non-finite ones are ignored."""
    if len(values) < 3:
        return np.zeros(0)
    second = np.abs(values[2:] - 2.0 * values[1:-1] + values[:-2]).reshape(len(values) - 2, -1)
    return np.asarray(second.max(axis=1, where=np.isfinite(second), initial=0.0))


def _steps_at(step: OneStep, x: Array, h: float, t: Sequence[float]) -> tuple[list[PathBatch], Array]:
    """Return steps of size h at each time, from the same states with the same noise, and the states after them."""
    rng = np.random.Generator(np.random.Philox(key=SEED + 3))
    noise = step.scheme.law.increment(step.view.drawn(rng, h, x.shape[1]), h)
    batches = [PathBatch(x, at, h, noise) for at in t]
    return batches, np.array([step.read(made.state) for made in step.together(batches)])
