"""Detection of moment explosion: rare noise after which the state grows doubly exponentially.

If the size of a state grows with a power m > 1 per step, |x_{n+1}| >= c |x_n|^m beyond a radius R(h), it is about
R^(m^n) after n steps. If noise leads beyond R(h) with a probability of at least exp(-R(h)^q), and R(h) grows like a
power of 1/h, the moments E|x_N|^p tend to infinity as h tends to 0: the size grows doubly exponentially in 1/h, and
the probability decreases exponentially in a power of 1/h (Hutzenthaler, Jentzen & Kloeden 2011, Theorem 1). Then
there is no order in mean square, although no sample shows the growth.

A run of the scheme is measured. So the noise must lead to states that grow, constraints are satisfied as the scheme
does, and growth without feedback (y = int W^3 dt) does not count. Sizes are compared with each other over a range of
eight decades, so that units do not matter.
"""

from collections.abc import Iterator
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, each
from ..contracts.scheme import Scheme, State
from ..errors import FAULTS
from ..forms import Problem
from .local.delay_links import remove_delay
from .step.nodes import SEED

# Factors by which the noise of one step is enlarged, and number of paths for each of them. The first factors are
# close to each other, because states of steep coefficients overflow beyond them at once.
FAR = 10.0 ** np.append(np.arange(1.0, 2.0, 0.25), np.arange(2.0, 10.0))
# Size: paths of a run.
PATHS = 6
# Ordinary steps before the large one, to forget the special start; largest and smallest number of steps after it.
# Size: steps of a run.
BEFORE, MOST, FEWEST = 2, 12, 5
# Step sizes, as divisors of the unit of time: growth at the first is confirmed at the second.
# Size: of the steps.
PARTS = 2.0**8, 2.0**10
# Exponents are compared over three steps, as feedback may take a step for each of position, velocity and noise:
# growth with the power 1.17 per step is a factor 1.6. Exponents that increase by a constant per step, as for v^2/r,
# increase by 9/6 in the three steps up to the ninth, until which numbers of this size do not overflow; their moments
# stay bounded.
# Theorem: elementary, 1.17^3 = 1.60 and 9/6 = 1.5.
WINDOW, RISE = 3, 1.6
NAME = "explosion"
# Runs begin at time 0, and again after this part of the horizon.
# Size: times at which runs begin.
LATE = 0.7
# The reported step is the first that increases the size by more than this number of decades.
# Words: of a reason.
SHOWN = 2.0
# Share of the paths that must explode: a single one may owe its growth to the noise of later steps.
SHARE = 0.5


class Explosion(NamedTuple):
    """Growth of the size of a state in the steps after rare noise.

    Attributes
    ----------
    power : ndarray, shape ()
        Power of the growth per step, averaged over the last three finite steps; 1 if it does not explode.
    h : ndarray, shape ()
        Step size.
    before, after : ndarray, shape ()
        Size of a state far out, and after the next step; NaN if it does not explode.
    """

    power: Array
    h: Array
    before: Array
    after: Array

    @property
    def explodes(self) -> bool:
        """Whether the size grows with a power above 1 per step, that is, doubly exponentially."""
        return float(self.power) > 1.0


@lru_cache(maxsize=8)
def explosion(scheme: Scheme, view: Problem) -> Explosion:
    """Return the growth of a scheme's runs after rare noise; none if steps far out raise or are not finite.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    pair = remove_delay(scheme, view)
    unit = pair[1].time_unit
    with np.errstate(all="ignore"):
        found = [_confirmed(*pair, unit, begin) for begin in (0.0, LATE * pair[1].horizon)]
    return max(found, key=_power_of)


def _confirmed(scheme: Scheme, view: Problem, unit: float, begin: float) -> Explosion:
    """Return the weaker growth of those at both step sizes."""
    found = _exploded(scheme, view, unit / PARTS[0], begin)
    if not found.explodes:
        return found
    return min(found, _exploded(scheme, view, unit / PARTS[1], begin), key=_power_of)


def _power_of(one: Explosion) -> float:
    return float(one.power)


def _exploded(scheme: Scheme, view: Problem, h: float, begin: float) -> Explosion:
    sizes = np.log10(np.array(list(_sizes(scheme, view, h, begin))))
    steady = Explosion(*map(np.array, (1.0, h, np.nan, np.nan)))
    if len(sizes) < 2:
        return steady
    # Exponents of the size as a function of the noise, for each step, path and interval of factors.
    slopes = np.diff(sizes.reshape(len(sizes), PATHS, len(FAR))) / np.diff(np.log10(FAR))
    lasting = np.isfinite(slopes).sum(axis=0)
    power = np.ones(lasting.shape)
    for n in range(2, len(slopes) + 1):
        window = min(WINDOW, n - 1)
        rise = slopes[n - 1] / np.maximum(slopes[n - 1 - window], 1.0)
        power = np.where((lasting == n) & (rise > RISE), rise ** (1.0 / window), power)
    # Growth must occur from some factor on for all larger ones: a threshold crossed once does not count.
    above = np.logical_and.accumulate((power > 1.0)[:, ::-1] | (lasting[:, ::-1] < 2), axis=1)[:, ::-1]
    power = np.where(above, power, 1.0)
    if (power > 1.0).any(axis=1).mean() < SHARE:
        return steady
    path, place = np.unravel_index(_first(power), power.shape)
    seen = sizes.reshape(len(sizes), PATHS, len(FAR))[: lasting[path, place], path, place + 1]
    step = int(np.argmax(np.append(np.diff(seen)[:-1] > SHOWN, True)))
    return Explosion(*map(np.array, (power[path, place], h, 10.0 ** seen[step], 10.0 ** seen[step + 1])))


def _first(power: Array) -> int:
    """Return the flat index of the path and interval that explode at the smallest noise."""
    return int(np.where(power > 1.0, np.arange(power.shape[1]), power.shape[1]).argmin())


def _sizes(scheme: Scheme, view: Any, h: float, begin: float) -> Iterator[Array]:
    """Yield the sizes of all paths after the large noise and each later step; NaN once they are not finite."""
    rng = np.random.Generator(np.random.Philox(key=SEED + 17))
    far = np.tile(FAR, PATHS)
    alive, noted = np.arange(len(far)), []
    try:
        start = scheme.enter(view, view.initial(len(far)), begin, h) if begin else scheme.start(view, len(far), h)
        state, make = start, scheme.prepare(view, h)
        for n in range(BEFORE + 1 + MOST):
            kick = far[alive] if n == BEFORE else 1.0
            noise = scheme.law.increment(view.drawn(rng, h, len(alive), kick), h)
            step = make(state, begin + n * h, noise)
            size = _size(scheme, view, step.state)
            good = np.isfinite(size) & (size > 0.0)
            if step.failed is not None:
                good &= ~step.failed
            alive, state = alive[good], each(partial(np.compress, good, axis=-1), step.state)
            if n >= BEFORE:
                noted.append(np.full(len(far), np.nan))
                noted[-1][alive] = size[good]
                yield noted[-1]
            if not len(alive) or (len(noted) > FEWEST and _is_flat(noted)):
                return
    except FAULTS:
        return


def _size(scheme: Scheme, view: Problem, state: State) -> Array:
    """Return the norm of the comparable components, shape (P,), the largest one, to avoid overflow of squares."""
    parts = np.concatenate([np.atleast_2d(part) for part in scheme.parts(view, state).values()])
    return np.asarray(np.abs(parts).max(axis=0))


def _is_flat(noted: list[Array]) -> bool:
    """Return whether the sizes grow with the noise no faster than after the first step."""
    first, last = (
        np.diff(np.log10(size).reshape(PATHS, len(FAR))) / np.diff(np.log10(FAR)) for size in (noted[0], noted[-1])
    )
    return bool(np.nanmax(last, initial=-np.inf) <= 1.05 * max(np.nanmax(first, initial=0.0), 1.0))
