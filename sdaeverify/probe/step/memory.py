"""Orders in h of the effect of a run's memory: up to these orders, results for single steps hold for runs.

A step is probed from states that `enter` creates, without a history. In a run, memory is left by previous steps.
Let X be a run, and Y the run on the same noise whose steps all begin with `enter` at the state of Y. Then

    ||X - x|| <= ||X - Y|| + ||Y - x||,    |E phi(X) - E phi(x)| <= |E phi(X) - E phi(Y)| + |E phi(Y) - E phi(x)|,

and single steps give the orders of Y. With ||X - Y|| = O(h^q) and E phi(X) - E phi(Y) = O(h^r) they verify no strong
order above q and no weak or invariant order above r. They refute no order unless their own order is below q or r: the
difference may cancel the error, as the older drift of a multistep method does.

X - Y is the sum of the differences D of single steps, transported by the flow. If D has a root mean square of order
q2 and, given the state, a mean of order q1, then r = q1 - 1 unless D is correlated with the increment and changes
variances, and q = min(q2 - 1/2, q1 - 1) if values of D a fixed number of steps apart are uncorrelated. Memory that
lasts longer adds up faster, differences that telescope more slowly. Runs include all of this, so X - Y is measured.
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import count
from typing import NamedTuple, Protocol

import numpy as np

from ...arrays import Array, each, join_batches
from ...contracts.scheme import Scheme, State, Stepper
from ...forms import Problem
from ...noise.brownian import BROWNIAN, USUAL, Brownian, Increment, LevelNoise, Source
from ..local.orders import FLAT, TOLERANCE
from .nodes import SEED

# Steps of the coarsest run, and its numbers of halvings: three sizes, each a fourth of the one before. Runs extend
# over the horizon, where memory may become active late, and, with steps 16 times shorter, over a sixteenth of it: a
# memory of ceil(h^(-1/5)/2) steps, for example, always has two steps at the first sizes.
# Size: of the runs.
COARSE, HALVINGS, SHORTER = 64, (0, 2, 4), 2.0**-4
# Number of equidistant times at which runs are compared: memory may become active late, or have decayed at the end.
# Size: times that are compared.
LOOKS = 4
# Number of paths, which gives a root mean square to 5 per cent, and its ratios on the same noise better. Whether
# memory has no effect beyond rounding is tested first on the smaller number, because it is a property of each path.
# Size: paths.
PATHS, FIRST = 256, 16
# Standard errors that are added to the size of a mean: an unresolved mean decreases as slowly as these.
# Level: 0.003 of a normal mean, two-sided; it only lowers the order that memory leaves.
ERRORS = 3.0
# Differences relative to the movement of a run are rounding below this size. Below `TOLERANCE` they are a solver's if
# they decrease with a lower order than `FLAT`.
# Rounding: 1024 steps of 64 operations err by 1.5e-11 if all errors have the same sign, else by a thirtieth of that.
ROUNDING = 1e-11
# Two orders of the effect of memory differ if they are half of 1/2 apart: orders of schemes are multiples of 1/2.
# Theorem: orders of schemes are multiples of 1/2.
NEAR = 0.25
# The lowest order of a convergent scheme is 1/2, and strong orders are known to 0.1. A lower order counts as none.
# Theorem: the least order is 1/2; less the tolerance of strong orders.
LEAST_ORDER = 0.4


class EnteredSteps(Protocol):
    """Interface of a one-step map that `memory_orders` needs; see `OneStep`."""

    @property
    def scheme(self) -> Scheme:
        """The scheme."""

    @property
    def view(self) -> Problem:
        """The problem in the scheme's form."""

    @property
    def names(self) -> dict[str, slice]:
        """Rows of each component in the state of the equation."""

    def enter(self, x: Array, t: float, h: float) -> State:
        """Return the scheme's state at x.

        Parameters
        ----------
        x : ndarray, shape (d, P)
        t : float
            Time of the state.
        h : float
            Size of the following steps.
        """

    def read(self, state: State) -> Array:
        """Return the comparable components of a state."""


class MemoryOrders(NamedTuple):
    """Orders in h of the effect of memory; infinite if the effect is rounding or a solver's tolerance.

    Attributes
    ----------
    strong : ndarray, shape (C,)
        Orders of root mean squares, by component; NaN if runs are not finite.
    weak : ndarray, shape ()
        Lowest order of the means of components and of their products, or of their standard errors if these are
        larger.
    """

    strong: Array
    weak: Array

    @property
    def vanish(self) -> bool:
        """Whether the effect tends to 0, so that single steps follow the equation if and only if runs do."""
        return bool(np.minimum(self.strong.min(), self.weak) > LEAST_ORDER)


@lru_cache(maxsize=16)
def memory_orders(step: EnteredSteps) -> MemoryOrders:
    """Return the orders of the difference between a run and a run with `enter` before each step.

    Parameters
    ----------
    step : EnteredSteps
        Of a scheme whose memory can be set by `enter`.
    """
    with np.errstate(all="ignore"):
        found = _compare(step, step.view.horizon)
        if not found.vanish or np.isinf(found.weak):
            return found
        later = _compare(step, SHORTER * step.view.horizon)
    return MemoryOrders(np.minimum(found.strong, later.strong), np.minimum(found.weak, later.weak))


def _compare(step: EnteredSteps, horizon: float) -> MemoryOrders:
    finest = _runs(step, horizon, HALVINGS[-1:], FIRST)
    if all(size.max() <= ROUNDING for size in _sizes(step, finest)):
        # Longer steps need no test: most memory is of components that each step solves for.
        return MemoryOrders(np.full(len(step.names), np.inf), np.array(np.inf))
    strong, weak = map(_falls, _sizes(step, _runs(step, horizon, HALVINGS, PATHS)))
    return MemoryOrders(strong, np.maximum(weak.min(), strong.min()))


def _runs(step: EnteredSteps, horizon: float, sizes: Sequence[int], paths: int) -> list[Array]:
    """Return states at the start and each look, shape (1 + L, 2, d, P), for runs with each number of halvings."""
    runs = [_PairedRuns(step, horizon / COARSE, halvings, paths) for halvings in sizes]
    fields, source = step.view.noise & {*BROWNIAN} | USUAL, Source(SEED, "memory", 0, paths)
    drawn = Brownian(source, step.view.noise_dim, horizon / COARSE, HALVINGS[-1], fields, step.view.records).steps()
    for place, levels in zip(range(COARSE), drawn, strict=False):
        for run in runs:
            run.follow(levels[run.halvings])
            if (place + 1) % (COARSE // LOOKS) == 0:
                run.seen.append(run.both)
    return [np.array(run.seen) for run in runs]


class _PairedRuns:
    """A run, and a run on the same noise with `enter` before each step; each step is made for both in one call."""

    def __init__(self, step: EnteredSteps, coarsest: float, halvings: int, paths: int) -> None:
        self.step, self.halvings, self.h = step, halvings, coarsest / 2**halvings
        self.make: Stepper = step.scheme.prepare(step.view, self.h)
        self.own: State = step.scheme.start(step.view, paths, self.h)
        self.both = np.stack([step.read(self.own)] * 2)
        self.places, self.seen = count(), [self.both]

    def follow(self, noise: LevelNoise) -> None:
        twice = each(lambda part: np.concatenate([part, part], axis=-1), noise)
        for n in range(len(noise.dW)):
            given: Increment = self.step.scheme.law.increment(twice.increment(n), self.h)
            t = next(self.places) * self.h
            state = self.make(join_batches([self.own, self.step.enter(self.both[1], t, self.h)], -1), t, given).state
            self.own = each(lambda part: np.split(part, 2, axis=-1)[0], state)
            self.both = np.stack(np.split(self.step.read(state), 2, axis=1))


def _sizes(step: EnteredSteps, seen: list[Array]) -> tuple[Array, Array]:
    """Return the largest difference of the two states over all looks, as root mean squares and in means.

    Parameters
    ----------
    step : EnteredSteps
    seen : list of H ndarrays
        Results of `_runs` for each step size, the finest last.

    Returns
    -------
    tuple of ndarray, shapes (H, C) and (H, F)
        By component, and by function; the maximum over looks, as periodic memory may be inactive at some looks.
    """
    found: Array = np.array(seen)
    begin, own, anew = found[:1, :1, 0], found[:, 1:, 0], found[:, 1:, 1]
    # In units of the movement of the finest run; for a component that does not move, of its size.
    moved = np.sqrt(np.nanmean((own[-1:] - begin) ** 2, axis=(1, 3), keepdims=True))
    unit = np.where(moved > 0.0, moved, 1.0 + np.abs(begin).max(axis=3, keepdims=True))
    own, anew = (own - begin) / unit, (anew - begin) / unit
    squares = np.mean((own - anew) ** 2, axis=3)
    rms = np.sqrt(np.stack([squares[:, :, rows].sum(axis=2) for rows in step.names.values()], axis=2))
    off = _functions(own) - _functions(anew)
    means = np.abs(off.mean(axis=3)) + ERRORS * off.std(axis=3) / np.sqrt(off.shape[3])
    return rms.max(axis=1), means.max(axis=1)


def _functions(x: Array) -> Array:
    """Return components and their products, for states of shape (..., d, P); shape (..., F, P)."""
    i, j = np.triu_indices(x.shape[-2])
    return np.concatenate([x, x[..., i, :] * x[..., j, :]], axis=-2)


def _falls(sizes: Array) -> Array:
    """Return the orders of differences of shape (H, ...), the lower of those over all sizes and over the last two."""
    floored = np.maximum(sizes, ROUNDING)
    last, overall = (np.log(floored[k] / floored[-1]) / np.log(2.0 ** (HALVINGS[-1] - HALVINGS[k])) for k in (-2, 0))
    # Coarse steps may be unstable; their order is then ignored.
    order = np.where(np.isfinite(overall), np.minimum(last, overall), last)
    alike = (sizes[-1] <= ROUNDING) | ((sizes[-1] < TOLERANCE) & (order < FLAT))
    return np.where(alike, np.inf, order)
