"""Orders in h of what the memory of a run changes: up to these, single steps speak for runs.

A step is probed from states that `enter` makes, without a history. In a run, memory is what the steps before left.
Let X be a run, and Y the run on the same noise whose steps all begin with `enter` at the state of Y. Then

    ||X - x|| <= ||X - Y|| + ||Y - x||,    |E phi(X) - E phi(x)| <= |E phi(X) - E phi(Y)| + |E phi(Y) - E phi(x)|,

and single steps tell the orders of Y. With ||X - Y|| = O(h^q) and E phi(X) - E phi(Y) = O(h^r) they verify no strong
order above q and no weak or invariant one above r, and refute none where their own order is not below these: the
difference may take back the error, as the older drift of a multistep method does.

X - Y is the sum of the differences D of single steps, carried on by the flow. If D has the root mean square h^q2 and,
given the state, the mean h^q1, then r = q1 - 1 unless D is correlated with the increment and changes variances, and
q = min(q2 - 1/2, q1 - 1) if values of D a fixed number of steps apart are uncorrelated. Memory that lasts longer adds
up faster, differences that telescope add up more slowly. Runs have all of that, so that X - Y itself is measured.
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import count
from typing import NamedTuple, Protocol

import numpy as np

from ...arrays import Array, each, join_batches
from ...contracts.scheme import Scheme, State, Stepper
from ...forms import Problem
from ...noise.brownian import BROWNIAN, USUAL, Increment, LevelNoise, Source, brownian_steps
from .nodes import SEED

# Steps of the coarsest run, and how often they are halved: three sizes, each a fourth of the one before. Runs go over
# the horizon, where memory may set in late, and on steps that are 16 times shorter over a sixteenth of it: memory of
# ceil(h^(-1/5)/2) steps is always of two on the first sizes.
# Size: of the runs.
COARSE, HALVINGS, SHORTER = 64, (0, 2, 4), 2.0**-4
# Times at which runs are compared, in parts of the horizon: memory may set in late, or be forgotten at the end.
# Size: times that are compared.
LOOKS = 4
# Paths: they know a root mean square to 5 per cent, and its quotients on the same noise better. That memory changes
# nothing beyond rounding is a property of each path, and is asked of a few first.
# Size: paths.
PATHS, FIRST = 256, 16
# Standard errors that are added to the size of a mean: what is not resolved falls as slowly as they do.
ERRORS = 3.0
# Differences below this part of what a run moves are rounding; below the other one, a solver's tolerance if they do
# not fall: the bounds of `probe.local.orders`.
ROUNDING, TOLERANCE, FLAT = 1e-11, 1e-6, 0.35
# Two orders of the effect of memory differ if they are half of 1/2 apart: orders of schemes are multiples of 1/2.
NEAR = 0.25
# The least order that a right scheme has is 1/2; strong orders are known to 0.1. What falls more slowly stays.
LEAST_ORDER = 0.4


class EnteredSteps(Protocol):
    """What is asked of a one-step map, see `OneStep`."""

    @property
    def scheme(self) -> Scheme:
        """The scheme."""

    @property
    def view(self) -> Problem:
        """The problem in the scheme's form."""

    @property
    def names(self) -> dict[str, slice]:
        """Rows of each component."""

    def enter(self, x: Array, t: float, h: float) -> State:
        """Return the scheme's state at x.

        Parameters
        ----------
        x : ndarray, shape (d, P)
        t : float
            When the scheme enters.
        h : float
            Size of the steps that follow.
        """

    def read(self, state: State) -> Array:
        """Return the comparable components of a state."""


class MemoryOrders(NamedTuple):
    """Orders in h of what memory changes; infinite where that is rounding or a solver's tolerance.

    Attributes
    ----------
    strong : ndarray, shape (C,)
        Of root mean squares, by component; NaN where runs are not finite.
    weak : ndarray, shape ()
        Least order of means of components and of their products, or of their standard errors where these are larger.
    """

    strong: Array
    weak: Array

    @property
    def vanish(self) -> bool:
        """Whether the difference tends to 0, so that single steps follow the equation if and only if runs do."""
        return bool(np.minimum(self.strong.min(), self.weak) > LEAST_ORDER)


@lru_cache(maxsize=16)
def memory_orders(step: EnteredSteps) -> MemoryOrders:
    """Compare runs of a scheme with further memory with runs that are entered anew at each step.

    Parameters
    ----------
    step : EnteredSteps
        Of a scheme whose memory `enter` sets.
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
        # Whatever longer steps show: most memory is of components that each step solves for.
        return MemoryOrders(np.full(len(step.names), np.inf), np.array(np.inf))
    strong, weak = map(_falls, _sizes(step, _runs(step, horizon, HALVINGS, PATHS)))
    return MemoryOrders(strong, np.maximum(weak.min(), strong.min()))


def _runs(step: EnteredSteps, horizon: float, sizes: Sequence[int], paths: int) -> list[Array]:
    """Return both states at the start and each look, shape (1 + L, 2, d, P), of runs with so many halvings."""
    runs = [_PairedRuns(step, horizon / COARSE, halvings, paths) for halvings in sizes]
    fields, source = step.view.noise & {*BROWNIAN} | USUAL, Source(SEED, "memory", 0, paths)
    drawn = brownian_steps(source, step.view.noise_dim, horizon / COARSE, HALVINGS[-1], fields, step.view.records)
    for place, levels in zip(range(COARSE), drawn, strict=False):
        for run in runs:
            run.follow(levels[run.halvings])
            if (place + 1) % (COARSE // LOOKS) == 0:
                run.seen.append(run.both)
    return [np.array(run.seen) for run in runs]


class _PairedRuns:
    """A run, and one on the same noise that is entered anew at each step: their paths make each step together."""

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
    """Return the largest differences of both states at a look, in the root mean square and in means.

    Parameters
    ----------
    step : EnteredSteps
    seen : list of H ndarrays
        Of runs of each size, the finest last; see `_runs`.

    Returns
    -------
    tuple of ndarray, shapes (H, C) and (H, F)
        By component, and of functions: memory that acts periodically may not have acted at each look.
    """
    found: Array = np.array(seen)
    begin, own, anew = found[:1, :1, 0], found[:, 1:, 0], found[:, 1:, 1]
    # In units of what the finest run moves: of a component that stays, of its size.
    moved = np.sqrt(np.nanmean((own[-1:] - begin) ** 2, axis=(1, 3), keepdims=True))
    unit = np.where(moved > 0.0, moved, 1.0 + np.abs(begin).max(axis=3, keepdims=True))
    own, anew = (own - begin) / unit, (anew - begin) / unit
    squares = np.mean((own - anew) ** 2, axis=3)
    rms = np.sqrt(np.stack([squares[:, :, rows].sum(axis=2) for rows in step.names.values()], axis=2))
    off = _functions(own) - _functions(anew)
    means = np.abs(off.mean(axis=3)) + ERRORS * off.std(axis=3) / np.sqrt(off.shape[3])
    return rms.max(axis=1), means.max(axis=1)


def _functions(x: Array) -> Array:
    """Return components and their products, for states in the last axes but one, shape (..., F, P)."""
    i, j = np.triu_indices(x.shape[-2])
    return np.concatenate([x, x[..., i, :] * x[..., j, :]], axis=-2)


def _falls(sizes: Array) -> Array:
    """Return the orders of differences of shape (H, ...), by which they fall over all sizes and over the last two."""
    floored = np.maximum(sizes, ROUNDING)
    last, overall = (np.log(floored[k] / floored[-1]) / np.log(2.0 ** (HALVINGS[-1] - HALVINGS[k])) for k in (-2, 0))
    # Coarse steps may not be stable.
    order = np.where(np.isfinite(overall), np.minimum(last, overall), last)
    alike = (sizes[-1] <= ROUNDING) | ((sizes[-1] < TOLERANCE) & (order < FLAT))
    return np.where(alike, np.inf, order)
