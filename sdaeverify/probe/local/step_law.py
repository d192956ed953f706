"""Law of single steps along runs: mean and covariance of short steps compared with those of the equation.

With Delta = Phi_h(x; xi) - x and the equation dx = f dt + B dW, every scheme that converges in law satisfies

    E Delta = f h + o(h),    E Delta Delta^T = B B^T h + o(h)

at each x and t that solutions reach (Milstein 1986), for any noise of the step. A scheme that converges along paths
also satisfies

    E Delta dW^T = B h + o(h),

because with the other two E |Delta - f h - B dW|^2 = o(h) if and only if this holds (Milstein 1988, Theorem 1). Nodes
that are exact up to degree 3 give all sides without sampling. Two sets of them alternate, so that a step with jumps
as a function of its noise, for which they are not accurate, has no limit by accident. If the limit is wrong, the
errors of the rates, E Delta/h - f, E Delta Delta^T/h - B B^T and E Delta dW^T/h - B, tend to a nonzero limit as h
tends to 0. Errors of positive order decrease; errors of a solver's tolerance, and rounding, increase like 1/h.
"""

from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...contracts.scheme import Scheme, Step
from ...forms import Delayed, Problem
from ...noise.records import NoiseRecord
from ...numerics.statistics import EPS
from ..step.nodes import Nodes, cross_with, law_nodes
from ..step.one_step import OneStep, why_not_resolved
from ..step.states import time_unit
from ..step.together import PathBatch
from ..step.two_rules import AGREEMENT
from .delay_links import remove_delay, why_not_algebraic
from .equation_rates import FINER, FIRST, LONGER, EquationRates, equation_rates

# Error of a rate, relative to its size, from which it is followed to shorter steps.
# Size: of what is followed; what is smaller is told as the resolution, `StepLaw.rate_error`.
SMALL = 1e-4
# A rate has a limit if its last two changes, over a factor of 16 each, are less than the first part of it: one like
# h^(1/8) changes by more. If it decreases faster than with the power 1/3, it is not followed further.
# Theorem: elementary, 1 - 16^(-1/8) = 0.29 and 16^(-1/3) = 0.40; orders are multiples of 1/2.
SETTLED, FALLING = 0.25, 0.4
# If the rules differ on this share of the errors, the step is no polynomial of its noise, and they agree on the
# others by accident.
MANY = 0.25
# Rounding: 64 operations of a step err by at most 64 eps of their sizes (Higham 2002, Lemma 3.1).
ROUNDINGS = 64.0
MOMENTS = ("mean", " (Ito/Stratonovich?)"), ("covariance", ""), ("covariance with the noise", "")
# Number of moments that determine the law of a step.
# Theorem: Milstein 1986.
IN_LAW = 2


class StepLaw(NamedTuple):
    """Deviation of the moments of short steps from those of the equation at n points (t, x), for C components.

    Attributes
    ----------
    rows : tuple of str
        Names of the C components.
    core : ndarray of bool, shape (C,)
        Whether drift or diffusion depend on a component; the others are pure outputs.
    t : ndarray, shape (n,)
    x : ndarray, shape (d, n)
    off : ndarray, shape (3, C, n)
        Errors of the rates of the mean, of the covariance and of the covariance with the noise at the shortest step
        size evaluated, relative to the motion of the solution: to |f| + |B|/sqrt(unit of time), to |B|^2 and to |B|.
    wrong : ndarray of bool, shape (3, C, n)
        Whether an error has a nonzero limit.
    """

    rows: tuple[str, ...]
    core: Array
    t: Array
    x: Array
    off: Array
    wrong: Array

    @property
    def points(self) -> int:
        """Number n of compared points (t, x)."""
        return len(self.t)

    @property
    def rate_error(self) -> float:
        """Largest remaining error of drift or noise at a point, relative to the solution's motion.

        A noise that is wrong by a factor 1 + e has a relative error of the covariance of 2 e.
        """
        law = self.off[:IN_LAW, self.core] * np.array([1.0, 0.5])[:, None, None]
        return float(law.max(initial=0.0))

    @property
    def departure(self) -> str:
        """Description of the largest deviation from the law of the equation, outputs apart, or an empty string."""
        wrong = self.wrong & self.core[:, None]
        wrong[IN_LAW:] = False
        return self.describe(wrong)

    def describe(self, wrong: Mask) -> str:
        """Describe the largest of some deviations in one line, or return an empty string if there are none.

        Parameters
        ----------
        wrong : ndarray of bool, shape (3, C, n)
        """
        if not wrong.any():
            return ""
        worst = np.where(wrong, self.off, -np.inf)
        moment, component, point = np.unravel_index(worst.argmax(), worst.shape)
        what, hint = MOMENTS[moment]
        where = f"{state_words(self.x[:, point])}, t = {self.t[point]:.3g}"
        off = f"off by {worst.max():.2g} of the motion of {self.rows[component]} at any h"
        also = f"at {int(wrong.any(axis=(0, 1)).sum())} of {self.points} points"
        return f"the {what} of one step from {where} is {off}, {also}: wrong equation{hint}"


class LawResolution(NamedTuple):
    """Resolution of a comparison of single steps with the equation, as evidence of a cell.

    Attributes
    ----------
    times : float
        Number of times, one in each part of the run, at which states were probed: errors in a smaller share may be
        missed.
    rate_error : float
        Largest undetected error of drift or noise at these, relative to the solution's motion; see `StepLaw`.
    """

    times: float
    rate_error: float


def law_resolution(scheme: Scheme, view: Problem) -> LawResolution | None:
    """Return the resolution of the comparison, or None if steps cannot be compared."""
    law = step_law(scheme, view)
    return None if law is None or not law.points else LawResolution(float(np.unique(law.t).size), law.rate_error)


def law_departure(scheme: Scheme, view: Problem) -> str:
    """Return the state and time from which short steps deviate from the equation, in one line, or an empty string.

    With a delay, steps before the first delay has passed are also compared.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    return next(filter(None, (law.departure for law in step_laws(scheme, view))), "")


def step_laws(scheme: Scheme, view: Problem) -> Iterator[StepLaw]:
    """Yield the comparisons with the equation that are possible: of steps after the first delay, and of those before.

    Without a delay there is one.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    pairs = [(scheme, view)]
    if view.capability(Delayed):
        pairs.append(remove_delay(scheme, view, 1))
    yield from (law for law in (step_law(*pair) for pair in pairs) if law is not None)


# Cached: all schemes of a problem are compared before the first one is measured.
@lru_cache(maxsize=64)
def step_law(scheme: Scheme, view: Problem) -> StepLaw | None:
    """Compare short steps with the equation at states that solutions reach, in all parts of the run.

    Cached, because it is needed before and during the measurement of a scheme.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form. With a delay, steps after the first delay are compared, see `remove_delay`.

    Returns
    -------
    StepLaw or None
        None if a step cannot be probed, or if steps of these sizes do not resolve the equation.
    """
    step = short_steps(scheme, view, beside=True)
    if step is None:
        return None
    return compare_at(step, equation_rates(step.view, step.equation))


def compare_at(step: OneStep, rates: EquationRates) -> StepLaw | None:
    """Compare short steps with the rates of the equation at given points; None without a rule for the noise.

    Parameters
    ----------
    step : OneStep
    rates : EquationRates
        Points and rates; fewer points are used if the rule for the noise has many nodes.
    """
    nodes = law_nodes(step.view.noise_dim, step.scheme.noise, step.scheme.law)
    if not nodes[0].exact:
        return None
    with np.errstate(all="ignore"):
        return _law(_ShortSteps(step, rates.for_nodes(len(nodes[0].weights)), nodes))


def short_steps(scheme: Scheme, view: Problem, *, beside: bool = False) -> OneStep | None:
    """Return the one-step map, without delay, to compare with the equation; None if it cannot be compared.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; see `step_law`.
    beside : bool
        Whether the probe has nodes for noise other than Brownian motions.
    """
    if view.capability(Delayed):
        if scheme.noise != {"dW"} or why_not_algebraic(scheme, view):
            return None
        scheme, view = remove_delay(scheme, view)
    step = OneStep(scheme, view)
    unknown = bool(view.records) and not beside
    if unknown or why_not_resolved(view, FINER[-1] * time_unit(view)) or step.why_not_comparable():
        return None
    return None if step.why_not_entered() else step


class _Off(NamedTuple):
    # Relative errors of the rates at S states of each of n times: of the mean, shape (n, d, S), of the covariance,
    # shape (n, S, d, d), and of that with the noise, shape (n, S, d, l); and the norms of the errors and of the
    # step's own rates, both beyond rounding for each component, shape (3, C, n, S).
    mean: Array
    square: Array
    cross: Array
    size: Array
    own: Array

    def of(self, places: Array) -> "_Off":
        beyond = self.size[:, :, places], self.own[:, :, places]
        return _Off(self.mean[places], self.square[places], self.cross[places], *beyond)


def _between(a: _Off, b: _Off) -> tuple[Array, Array, Array]:
    return a.mean - b.mean, a.square - b.square, a.cross - b.cross


def _recovers(found: list[_Off]) -> Mask:
    """Return where the step's own rates grow with each shorter size, by more than a settled rate, as the errors fall.

    Noise that is divided by 1 + h^(1/2) |x|^2 has an error of nearly 1 while h^(1/2) |x|^2 is large. What is left of
    it grows as h falls, so that the error is no limit.
    """
    each = [(a.own < (1.0 - SETTLED) * b.own) & (a.size >= b.size) for a, b in pairwise(found)]
    return np.asarray(np.all(each, axis=0))


def _moments(moved: Array, nodes: Nodes, h: float) -> tuple[Array, Array, Array]:
    """Return E Delta/h, E Delta Delta^T/h and E Delta dW^T/h of displacements, shape (n, S, d, K)."""
    weighed = moved * nodes.weights
    mean = np.moveaxis(weighed.sum(axis=-1), 1, 2) / h
    return mean, weighed @ moved.swapaxes(2, 3) / h, weighed @ nodes.dW.T / np.sqrt(h)


class _ShortSteps(NamedTuple):
    """Steps of a scheme to compare with the law of the equation, at two alternating sets of nodes."""

    step: OneStep
    rates: EquationRates
    nodes: tuple[Nodes, Nodes]

    def limits(self) -> tuple[Array, Array]:
        """Return the errors of the rates, and whether they have a nonzero limit; both of shape (3, C, n, S)."""
        first = self._off(np.arange(len(self.rates.t)), FIRST)
        left, wrong = first.size.copy(), np.zeros(first.size.shape, dtype=bool)
        asked = np.flatnonzero((first.size > SMALL).any(axis=(0, 1, 3)))
        if asked.size:
            found = self._followed(asked, first.of(asked))
            left[:, :, asked] = found[-1].size
            if len(found) > len(FINER):
                left[:, :, asked], wrong[:, :, asked] = self._limits(asked, found)
        if wrong.any():
            truncated = self._truncated(asked)
            left[:, :, asked] = np.where(truncated, np.nan, left[:, :, asked])
            wrong[:, :, asked] &= ~truncated
        return left, wrong

    def _followed(self, asked: Array, first: _Off) -> list[_Off]:
        """Return the errors for shorter and shorter steps, until they decrease."""
        found = [first]
        for number, size in enumerate(FINER.tolist(), 1):
            found.append(self._off(asked, size, number % 2))
            if not (found[-1].size > np.fmax(SMALL, FALLING * found[-2].size)).any():
                break
        return found

    def _limits(self, asked: Array, found: list[_Off]) -> tuple[Array, Mask]:
        """Return the errors, and whether both rules agree on a nonzero limit, of the finest or of longer steps."""
        first, finest = found[0], found[-1]
        lasts, settled = ~_recovers(found[-len(FINER) :]), self._settled(found[-len(FINER) :])
        stands = settled & lasts & (first.size > 0.5 * finest.size)
        wrong = self._agreed(asked, finest, FINER[-1], stands)
        longer = [self._off(asked, size) for size in LONGER.tolist()]
        hidden = np.min([each.size for each in found], axis=0) > 0.5 * longer[-1].size
        before = self._agreed(asked, longer[-1], LONGER[-1], self._settled(longer) & hidden & ~wrong & lasts)
        return np.where(before, longer[-1].size, finest.size), wrong | before

    def _agreed(self, asked: Array, last: _Off, size: float, wrong: Mask) -> Mask:
        """Return the limits on which both rules agree; none if they differ at many, as for a step with jumps."""
        if not wrong.any():
            return wrong
        other, large = self._off(asked, size, 0 if size == FINER[-1] else 1), last.size > SMALL
        differ = large & (self._norms(*_between(last, other)) > AGREEMENT * last.size)
        return wrong & ~differ if differ.sum() < MANY * large.sum() else np.zeros_like(wrong)

    def _settled(self, found: list[_Off]) -> Mask:
        """Return where the errors at three sizes have settled."""
        changes = [self._norms(*_between(a, b)) for a, b in pairwise(found)]
        return np.asarray((np.fmax(*changes) <= SETTLED * found[-1].size) & (found[-1].size > SMALL))

    def _off(self, places: Array, part: float, which: int = 0) -> _Off:
        """Return the relative errors of drift and covariance at some of the times, for steps of one size."""
        rates, h = self.rates, float(part * self.step.time_unit)
        nodes, x, size = self._nodes(which, h), rates.x[places], self._divisors(places)
        found = _moments(self._moved(places, nodes, h), nodes, h)
        right = _moments(self._euler_moved(places, nodes, h), nodes, h) if self.records else rates.moments(places)
        drift, root = np.full_like(x, np.inf), np.full_like(x, np.inf)
        for rows, own, _, noise in zip(rates.rows.values(), *size, strict=True):
            drift[:, rows], root[:, rows] = own[:, None], noise[:, None]
        each = root.swapaxes(1, 2)
        divisors = drift, each[..., None] * each[:, :, None], each[..., None]
        mean, square, cross = ((a - b) / size for a, b, size in zip(found, right, divisors, strict=True))
        rounding = ROUNDINGS * EPS * np.abs(x).max(axis=1) / h
        beside, one = rounding / size[2], np.sqrt(h)
        explained = np.stack([rounding / size[0], beside * (2.0 * one + h * beside), one * beside])
        own = self._norms(*(a / size for a, size in zip(found, divisors, strict=True)))
        beyond = [norms - explained for norms in (self._norms(mean, square, cross), own)]
        return _Off(mean, square, cross, *(np.nan_to_num(each, nan=0.0, posinf=0.0) for each in beyond))

    @property
    def records(self) -> tuple[NoiseRecord, ...]:
        """Kinds of noise other than Brownian motions, whose moments are those of Euler's step."""
        return self.step.view.records

    def _nodes(self, which: int, h: float) -> Nodes:
        """Return one of the rules with all noise of a step of size h."""
        found = self.nodes[which]
        for record in self.records:
            found = cross_with(found, record.name, *record.rule(h))
        return found

    def _divisors(self, places: Array) -> Array:
        """Return the divisors of the errors of the three rates at some of the times, shape (3, C, n, S)."""
        drift, noise = self.rates.size[:, :, places]
        return np.stack([drift, noise, np.sqrt(noise)])

    def _moved(self, places: Array, nodes: Nodes, h: float) -> Array:
        """Return the displacements by steps, shape (n, S, d, K)."""
        return self._by_state([self.step.read(made.state) - x for x, made in self._made(places, nodes, h)])

    def _euler_moved(self, places: Array, nodes: Nodes, h: float) -> Array:
        noise = nodes.increment(h, self.rates.x.shape[-1])
        wide = np.repeat(self.rates.x[places], len(nodes.weights), axis=2)
        times = self.rates.t[places].tolist()
        return self._by_state([self.step.euler(x, t, h, noise) - x for x, t in zip(wide, times, strict=True)])

    def _by_state(self, moved: list[Array]) -> Array:
        _, d, S = self.rates.x.shape
        return np.moveaxis(np.reshape(moved, (len(moved), d, S, -1)), 1, 2)

    def _truncated(self, places: Array) -> Mask:
        """Return which states (n, S) have truncated shortest steps for some noise; these have no limit yet."""
        S, h = self.rates.x.shape[-1], FINER[-1] * self.step.time_unit
        nodes = self._nodes(-1, h)
        noise, times = nodes.increment(h, S), self.rates.t[places].tolist()
        masks = [
            self.step.leaves_domain(x, t, h, noise) | (False if made.truncated is None else made.truncated)
            for t, (x, made) in zip(times, self._made(places, nodes, h), strict=True)
        ]
        return np.array([mask.reshape(S, -1).any(axis=1) for mask in masks])

    def _made(self, places: Array, nodes: Nodes, h: float) -> Iterator[tuple[Array, Step]]:
        """Return pairs of the states of each time, repeated for each node, shape (d, S K), and the step from them."""
        noise = nodes.increment(h, self.rates.x.shape[-1])
        wide = np.repeat(self.rates.x[places], len(nodes.weights), axis=2)
        batches = [PathBatch(x, t, h, noise) for t, x in zip(self.rates.t[places].tolist(), wide, strict=True)]
        return zip(wide, self.step.together(batches), strict=True)

    def _norms(self, mean: Array, *others: Array) -> Array:
        """Return the norms of the errors of the rates for each component, shape (3, C, n, S)."""
        rows = self.rates.rows.values()
        means = [np.linalg.norm(mean[:, part], axis=1) for part in rows]
        square, cross = ([part[:, :, own] for own in rows] for part in others)
        squares = [np.linalg.norm(part[..., own], axis=(2, 3)) for part, own in zip(square, rows, strict=True)]
        return np.array([means, squares, [np.linalg.norm(part, axis=(2, 3)) for part in cross]])


def _law(steps: _ShortSteps) -> StepLaw:
    rates = steps.rates
    off, wrong = steps.limits()
    known = (
        np.isfinite(rates.size).any(axis=(0, 1))
        & np.isfinite(rates.f).all(axis=1)
        & np.isfinite(off).all(axis=(0, 1))
    )
    off, wrong = off[..., known], wrong[..., known]
    t = np.broadcast_to(rates.t[:, None], known.shape)[known]
    return StepLaw(tuple(rates.rows), rates.core, t, np.moveaxis(rates.x, 1, 0)[:, known], off, wrong)


def state_words(x: Array) -> str:
    """Format the first components of a state, shape (d,)."""
    return f"[{', '.join(f'{value:.3g}' for value in x[:4])}{', ...' if len(x) > 4 else ''}]"
