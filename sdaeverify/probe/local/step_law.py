"""Law of single steps along runs: mean and covariance of short steps compared with those of the equation.

With Delta = Phi_h(x; xi) - x and the equation dx = f dt + B dW, every scheme that converges in law satisfies

    E Delta = f h + o(h),    E Delta Delta^T = B B^T h + o(h)

at each x and t that solutions reach (Milstein 1986), for any noise of the step. Nodes that are exact up to
degree 3 give both sides without sampling. Two sets of them alternate, so that a step with jumps as a function of
its noise, for which they are not accurate, has no limit by accident. If the limit is wrong, the errors of the rates,
E Delta/h - f and E Delta Delta^T/h - B B^T, tend to a nonzero limit as h tends to 0. Errors of positive order
decrease; errors of a solver's tolerance, and rounding, increase like 1/h.
"""

from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Mask
from ...contracts.scheme import Scheme, Step
from ...forms import Delayed, Equation, Problem
from ...numerics.statistics import EPS
from ..step.nodes import Nodes, law_nodes
from ..step.one_step import OneStep, why_not_resolved
from ..step.states import cloud, reached_states, time_unit
from ..step.together import PathBatch
from ..step.two_rules import AGREEMENT
from .delay_links import remove_delay, why_not_algebraic
from .orders import TOLERANCE
from .reach import core

# Step sizes in units of the horizon, or of time if that is shorter. If the error of a rate is small at the first
# size, so is its limit. If not, the finer sizes give the limit, and the coarse one shows that the error is not
# smaller there: errors that occur only at steps shorter than a solver's tolerance are found elsewhere.
FIRST, FINER, COARSE = 4.0**-9.0, 4.0 ** -np.array([11.0, 13.0, 15.0]), 4.0**-6.0
LAST = (*FINER.tolist(), COARSE)
# Error of a rate, relative to its size, from which it is followed to shorter steps.
SMALL = 1e-4
# A rate has a limit if its last two changes, over a factor of 16 each, are less than the first part of it: one like
# h^(1/8) changes by more. If it decreases faster than with the power 1/3, it is not followed further.
SETTLED, FALLING = 0.25, 0.4
# If the rules differ on this share of the errors, the step is no polynomial of its noise, and they agree on the
# others by accident.
MANY = 0.25
# A drift that moves a state by more than this in the shortest step may be tamed or truncated in all of them.
MOVED = 0.01
# Part of the typical size of drift and noise that is added to their size, so that errors can be relative where these
# vanish.
TYPICAL = 0.2
ROUNDINGS = 64.0
# Largest product of components, nodes, states and times for one step size: for large systems fewer times are used,
# but at least this number.
# Size: memory, and parts of the run.
MOST, FEWEST = 2**17, 4
# States times nodes of a step: with more nodes there are fewer states.
# Size: states times nodes.
WORK = 256
MOMENTS = ("mean", " (Ito/Stratonovich?)"), ("covariance", "")


class StepLaw(NamedTuple):
    """Deviation of the law of short steps from that of the equation at n points (t, x), for C components.

    Attributes
    ----------
    rows : tuple of str
        Names of the C components on which drift or diffusion depend; pure outputs are left out.
    t : ndarray, shape (n,)
    x : ndarray, shape (d, n)
    off : ndarray, shape (2, C, n)
        Errors of the rates of mean and covariance at the shortest step size evaluated, relative to the motion of the
        solution: to |f| + |B|/sqrt(unit of time), and to |B|^2.
    wrong : ndarray of bool, shape (2, C, n)
        Whether an error has a nonzero limit.
    """

    rows: tuple[str, ...]
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
        return float((self.off * np.array([1.0, 0.5])[:, None, None]).max(initial=0.0))

    @property
    def departure(self) -> str:
        """Description of the largest deviation from the equation, in one line, or an empty string."""
        if not self.wrong.any():
            return ""
        worst = np.where(self.wrong, self.off, -1.0)
        moment, component, point = np.unravel_index(worst.argmax(), worst.shape)
        what, hint = MOMENTS[moment]
        where = f"{state_words(self.x[:, point])}, t = {self.t[point]:.3g}"
        off = f"off by {worst.max():.2g} of the motion of {self.rows[component]} at any h"
        also = f"at {int(self.wrong.any(axis=(0, 1)).sum())} of {self.points} points"
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
    law = step_law(scheme, view)
    if law is None or law.wrong.any() or not view.capability(Delayed):
        return "" if law is None else law.departure
    early = step_law(*remove_delay(scheme, view, 1))
    return "" if early is None else early.departure


# Cached: all schemes of a problem are compared before the first one is measured.
@lru_cache(maxsize=64)
def step_law(scheme: Scheme, view: Problem) -> StepLaw | None:
    """Compare the law of short steps with the equation at states that solutions reach, in all parts of the run.

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
    step = short_steps(scheme, view)
    if step is None:
        return None
    nodes = law_nodes(step.view.noise_dim, step.scheme.noise, step.scheme.law)
    if not nodes[0].exact:
        return None
    rates = equation_rates(step.view, step.equation).for_nodes(len(nodes[0].weights))
    if not rates.rows:
        return None
    with np.errstate(all="ignore"):
        return _law(_ShortSteps(step, rates, nodes))


def short_steps(scheme: Scheme, view: Problem) -> OneStep | None:
    """Return the one-step map, without delay, to compare with the equation; None if it cannot be compared.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; see `step_law`.
    """
    if view.capability(Delayed):
        if scheme.noise != {"dW"} or why_not_algebraic(scheme, view):
            return None
        scheme, view = remove_delay(scheme, view)
    step = OneStep(scheme, view)
    if (
        why_not_resolved(view, FINER[-1] * time_unit(view))
        or view.records
        or step.why_not_comparable()
        or step.why_not_entered()
    ):
        return None
    return step


class EquationRates(NamedTuple):
    """Rates of mean and covariance of an equation's solution at S states for each of n times.

    Attributes
    ----------
    t : ndarray, shape (n,)
    x, f : ndarray, shape (n, d, S)
    C : ndarray, shape (n, S, d, d)
        B B^T.
    rows : dict of str to slice
        Rows of the components on which drift or diffusion depend.
    size : ndarray, shape (2, C, n, S)
        Divisors of the errors of both rates; infinite where they are not to be compared.
    """

    t: Array
    x: Array
    f: Array
    C: Array
    rows: dict[str, slice]
    size: Array

    def for_nodes(self, count: int) -> "EquationRates":
        """Return a selection of states and times small enough for `count` nodes, including the extreme states."""
        some = slice(-max(WORK // count, 2), None)
        columns = len(self.x[0]) * count * len(self.x[0, 0, some])
        when = slice(None, None, -(-len(self.t) // max(MOST // columns, FEWEST)))
        x, f = self.x[when, :, some], self.f[when, :, some]
        return EquationRates(self.t[when], x, f, self.C[when, some], self.rows, self.size[:, :, when, some])


# Cached, as it is the same for all schemes of a form.
@lru_cache(maxsize=8)
def equation_rates(view: Problem, equation: Equation) -> EquationRates:
    """Return the rates at the states that solutions reach.

    Parameters
    ----------
    view : Problem
    equation : Equation
        Ito equation of the comparable components.
    """
    t, x = reached_states(view, equation)
    h = COARSE * time_unit(view)
    # Steps of all sizes begin at multiples of the coarse size, after the first step and before the last one.
    t = h * np.clip(np.floor(t / h), 1.0, np.floor(view.horizon / h) - 2.0)
    with np.errstate(all="ignore"):
        f = np.stack([np.broadcast_to(equation.drift(s, y), y.shape) for s, y in zip(t.tolist(), x, strict=True)])
        C = np.stack([_squares(equation, s, y) for s, y in zip(t.tolist(), x, strict=True)])
        names = equation.names or {"x": slice(None)}
        counted = core(equation, names, cloud(view, equation))
        rows = {name: part for (name, part), counts in zip(names.items(), counted, strict=True) if counts}
        sizes = _sizes(time_unit(view), f, C, list(rows.values())) if rows else np.zeros((2, 0, len(t), x.shape[2]))
        return EquationRates(t, x, f, C, rows, sizes)


def _squares(equation: Equation, t: float, x: Array) -> Array:
    B = np.broadcast_to(equation.diffusion(t, x), (len(x), equation.noise_dim, x.shape[1]))
    return np.asarray(np.einsum("iks,jks->sij", B, B))


def _sizes(unit: float, f: Array, C: Array, rows: list[slice]) -> Array:
    """Return |f| + |B|/sqrt(unit) and |B|^2 of each component, or unit |f|^2 for components without noise."""
    drift = np.stack([np.linalg.norm(f[:, part], axis=1) for part in rows])
    noise = np.stack([np.linalg.norm(C[..., part, part], axis=(2, 3)) for part in rows])
    speed = drift + np.sqrt(noise / unit)
    typical = np.nanmedian(np.stack([speed, noise]), axis=(2, 3), keepdims=True)
    motion = np.stack([speed, np.where(typical[1] > 0.0, noise, unit * speed**2)])
    size = motion + TYPICAL * np.nanmedian(motion, axis=(2, 3), keepdims=True)
    moved = FINER[-1] * unit * np.linalg.norm(f, axis=1)
    return np.where((size > 0.0) & (moved < MOVED), size, np.inf)


class _Off(NamedTuple):
    # Relative errors of the rates at S states of each of n times: of the mean, shape (n, d, S), of the covariance,
    # shape (n, S, d, d); and their norms beyond rounding for each component, shape (2, C, n, S).
    mean: Array
    square: Array
    size: Array

    def of(self, places: Array) -> "_Off":
        return _Off(self.mean[places], self.square[places], self.size[:, :, places])


def _between(a: _Off, b: _Off) -> tuple[Array, Array]:
    return a.mean - b.mean, a.square - b.square


class _ShortSteps(NamedTuple):
    """Steps of a scheme to compare with the law of the equation, at two alternating sets of nodes."""

    step: OneStep
    rates: EquationRates
    nodes: tuple[Nodes, Nodes]

    def limits(self) -> tuple[Array, Array]:
        """Return the errors of the rates, and whether they have a nonzero limit; both of shape (2, C, n, S)."""
        first = self._off(np.arange(len(self.rates.t)), FIRST)
        left, wrong = first.size.copy(), np.zeros(first.size.shape, dtype=bool)
        asked = np.flatnonzero((first.size > SMALL).any(axis=(0, 1, 3)))
        if asked.size:
            found = self._followed(asked, first.of(asked))
            left[:, :, asked] = found[-1].size
            if len(found) > len(FINER):
                found.append(self._off(asked, COARSE))
                wrong[:, :, asked] = self._agreed(asked, found[-2], self._stands(asked, found))
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

    def _agreed(self, asked: Array, finest: _Off, wrong: Mask) -> Mask:
        """Return the limits on which both rules agree; none if they differ at many, as for a step with jumps."""
        if not wrong.any():
            return wrong
        other, large = self._off(asked, FINER[-1]), finest.size > SMALL
        differ = large & (self._norms(*_between(finest, other)) > AGREEMENT * finest.size)
        return wrong & ~differ if differ.sum() < MANY * large.sum() else np.zeros_like(wrong)

    def _stands(self, asked: Array, found: list[_Off]) -> Mask:
        """Return where errors have a limit as rates, as moves of size sqrt(h), or as moves above a tolerance."""
        moves = FINER[-1] * self.step.time_unit * self.rates.size[:, :, asked] * found[-2].size
        tolerance = TOLERANCE * np.abs(self.rates.x[asked]).max(axis=1)
        jumps = self._settled(found, 1.0) & (moves > np.stack([tolerance, tolerance**2])[:, None])
        return np.asarray(jumps | self._settled(found, 0.5) | self._settled(found, 0.0))

    def _settled(self, found: list[_Off], power: float) -> Mask:
        """Return where h^power times the last three errors has settled, and is not smaller for coarse steps."""
        scaled = [_Off(*(size**power * part for part in off)) for size, off in zip(LAST, found[-4:], strict=True)]
        *fine, coarse = scaled
        changes = [self._norms(*_between(a, b)) for a, b in pairwise(fine)]
        least = fine[-1].size
        settled = (np.fmax(*changes) <= SETTLED * least) & (coarse.size > 0.5 * least)
        return np.asarray(settled & (found[-2].size > SMALL))

    def _off(self, places: Array, part: float, which: int = 0) -> _Off:
        """Return the relative errors of drift and covariance at some of the times, for steps of one size."""
        rates, nodes, h = self.rates, self.nodes[which], part * self.step.time_unit
        x, size, moved = rates.x[places], rates.size[:, :, places], self._moved(places, nodes, h)
        mean = np.moveaxis(moved @ nodes.weights, 1, 2) / h - rates.f[places]
        square = (moved * nodes.weights) @ moved.swapaxes(2, 3) / h - rates.C[places]
        drift, root = np.full_like(x, np.inf), np.full_like(x, np.inf)
        for rows, own, noise in zip(rates.rows.values(), *size, strict=True):
            drift[:, rows], root[:, rows] = own[:, None], np.sqrt(noise)[:, None]
        each = root.swapaxes(1, 2)
        mean, square = mean / drift, square / (each[..., None] * each[:, :, None])
        rounding = ROUNDINGS * EPS * np.abs(x).max(axis=1) / h
        beside = rounding / np.sqrt(size[1])
        explained = np.stack([rounding / size[0], beside * (2.0 * np.sqrt(h) + h * beside)])
        return _Off(mean, square, np.nan_to_num(self._norms(mean, square) - explained, nan=0.0, posinf=0.0))

    def _moved(self, places: Array, nodes: Nodes, h: float) -> Array:
        """Return the displacements by steps, shape (n, S, d, K)."""
        (_, d, S), count = self.rates.x.shape, len(nodes.weights)
        moved = [self.step.read(made.state) - x for x, made in self._made(places, nodes, h)]
        return np.moveaxis(np.reshape(moved, (len(places), d, S, count)), 1, 2)

    def _truncated(self, places: Array) -> Mask:
        """Return which states (n, S) have truncated shortest steps for some noise; these have no limit yet."""
        nodes, S, h = self.nodes[-1], self.rates.x.shape[-1], FINER[-1] * self.step.time_unit
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

    def _norms(self, mean: Array, square: Array) -> Array:
        """Return the norms of the errors of the rates for each component, shape (2, C, n, S)."""
        rows = self.rates.rows.values()
        means = [np.linalg.norm(mean[:, part], axis=1) for part in rows]
        squares = [np.sqrt(np.einsum("nsij,nsij->ns", square[:, :, part], square[:, :, part])) for part in rows]
        return np.array([means, squares])


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
    return StepLaw(tuple(rates.rows), t, np.moveaxis(rates.x, 1, 0)[:, known], off, wrong)


def state_words(x: Array) -> str:
    """Format the first components of a state, shape (d,)."""
    return f"[{', '.join(f'{value:.3g}' for value in x[:4])}{', ...' if len(x) > 4 else ''}]"
