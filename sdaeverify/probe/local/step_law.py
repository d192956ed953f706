"""The law of single steps along runs: mean and covariance of a short step against those of the equation.

With Delta = Phi_h(x; xi) - x and the equation dx = f dt + B dW, whatever converges in law has

    E Delta = f h + o(h),    E Delta Delta^T = B B^T h + o(h)

at each x and t that solutions reach (Milstein 1986), whatever noise the step uses. Nodes that are exact up to the
third degree tell both sides without sampling; two sets of them take turns, so that a step that jumps as a function of
its noise, for which they are no rules, has no limit by accident. What is wrong with the limit does not fall as steps
are shortened: the rates E Delta/h - f and E Delta Delta^T/h - B B^T tend to it. What is of some order falls; what a
solver leaves of an equation, and rounding, rises like 1/h.
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

# In units of the horizon, or of time where that is shorter. Where the rate of an error is small on the first, its
# limit is; where it is not, the others tell the limit, and that the first two are no smaller: what only steps do that
# are shorter than a solver's tolerance is told elsewhere.
FIRST, FINER, COARSE = 4.0**-9.0, 4.0 ** -np.array([11.0, 13.0, 15.0]), 4.0**-6.0
LAST = (*FINER.tolist(), COARSE)
# A part of the rates that is asked what becomes of it on shorter steps.
SMALL = 1e-4
# A rate has a limit where its last two changes, over a factor of 16 each, are less than this part of it: what falls
# like h^(1/8) changes by more. What falls faster than with the power 1/3 is not followed further.
SETTLED, FALLING = 0.25, 0.4
# Rules that differ on so many of the errors do so because a step is no polynomial of its noise: they agree on others
# by accident.
MANY = 0.25
# A drift that moves a state by more than this in the shortest step may be tamed or truncated in all of them.
MOVED = 0.01
# Of the size that drift and noise have at other states: where they are 0 themselves, nothing is a part of them.
TYPICAL = 0.2
ROUNDINGS = 64.0
# Components, nodes, states and times of steps of one size, multiplied: of large systems fewer parts of the run are
# looked at, and no fewer than so many.
# Size: memory, and parts of the run.
MOST, FEWEST = 2**17, 4
# States times nodes of a step: of more nodes there are fewer states.
# Size: states times nodes.
WORK = 256
MOMENTS = ("mean", " (Ito/Stratonovich?)"), ("covariance", "")


class StepLaw(NamedTuple):
    """How far the law of short steps is from that of the equation at n points (t, x) of C components.

    Attributes
    ----------
    rows : tuple of str
        Names of the C components that drift or diffusion depend on: what is an output alone is no state.
    t : ndarray, shape (n,)
    x : ndarray, shape (d, n)
    off : ndarray, shape (2, C, n)
        Errors of the rates of mean and covariance at the shortest step that they were looked at, in parts of the
        motion of the solution: of |f| + |B|/sqrt(unit of time), and of |B|^2.
    wrong : ndarray of bool, shape (2, C, n)
        Where an error has a limit.
    """

    rows: tuple[str, ...]
    t: Array
    x: Array
    off: Array
    wrong: Array

    @property
    def points(self) -> int:
        """Number n of points."""
        return len(self.t)

    @property
    def rate_error(self) -> float:
        """The largest error of drift or noise that may be left at a point, in parts of the solution's motion.

        A noise that is wrong by a factor 1 + e has a covariance that is wrong by 2 e of itself.
        """
        return float((self.off * np.array([1.0, 0.5])[:, None, None]).max(initial=0.0))

    @property
    def departure(self) -> str:
        """Where the law is not that of the equation, in one line, or an empty string."""
        if not self.wrong.any():
            return ""
        worst = np.where(self.wrong, self.off, -1.0)
        moment, component, point = np.unravel_index(worst.argmax(), worst.shape)
        what, hint = MOMENTS[moment]
        where = f"{state_words(self.x[:, point])}, t = {self.t[point]:.3g}"
        off = f"off by {worst.max():.2g} of the motion of {self.rows[component]} at any h"
        also = f"at {int(self.wrong.any(axis=(0, 1)).sum())} of {self.points} points"
        return f"the {what} of one step from {where} is {off}, {also}: another equation{hint}"


class LawResolution(NamedTuple):
    """What a comparison of single steps with the equation would have seen; as evidence of a cell.

    Attributes
    ----------
    times : float
        At how many times, one in each part of the run, states were looked at: a smaller share of a run may be missed.
    rate_error : float
        How far drift or noise may be off at these at most, in parts of the solution's motion; see `StepLaw`.
    """

    times: float
    rate_error: float


def law_resolution(scheme: Scheme, view: Problem) -> LawResolution | None:
    """Return what was looked at and what would have been seen, or None where steps cannot be compared."""
    law = step_law(scheme, view)
    return None if law is None or not law.points else LawResolution(float(np.unique(law.t).size), law.rate_error)


def law_departure(scheme: Scheme, view: Problem) -> str:
    """Return at which state and time short steps leave the equation, in one line, or an empty string.

    Steps up to the first delay, where there is one, are compared as well.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    """
    law = step_law(scheme, view)
    if law is None or law.wrong.any() or not view.capability(Delayed):
        return "" if law is None else law.departure
    early = step_law(*remove_delay(scheme, view, 1))
    return "" if early is None else early.departure


# All schemes of a problem are compared before the first one is measured.
@lru_cache(maxsize=64)
def step_law(scheme: Scheme, view: Problem) -> StepLaw | None:
    """Compare the law of short steps with the equation at states that solutions reach, in all parts of the run.

    Remembered, because it is asked for before and while a scheme is measured.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form. Where it has a delay, steps after the first one are compared, see `remove_delay`.

    Returns
    -------
    StepLaw or None
        None where a step cannot be probed, and where steps so short do not resolve the equation.
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
    """Return the one-step map that is compared with the equation, without delay; None where it cannot be compared.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        As of `step_law`.
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
    """Rates of mean and covariance of an equation's solution at S states of each of n times.

    Attributes
    ----------
    t : ndarray, shape (n,)
    x, f : ndarray, shape (n, d, S)
    C : ndarray, shape (n, S, d, d)
        B B^T.
    rows : dict of str to slice
        Of the components that drift or diffusion depend on.
    size : ndarray, shape (2, C, n, S)
        By which errors of both are divided; infinite where nothing is to be compared.
    """

    t: Array
    x: Array
    f: Array
    C: Array
    rows: dict[str, slice]
    size: Array

    def for_nodes(self, count: int) -> "EquationRates":
        """Return the last states of each time, with the extremes, and as many times as so many nodes allow."""
        some = slice(-max(WORK // count, 2), None)
        columns = len(self.x[0]) * count * len(self.x[0, 0, some])
        when = slice(None, None, -(-len(self.t) // max(MOST // columns, FEWEST)))
        x, f = self.x[when, :, some], self.f[when, :, some]
        return EquationRates(self.t[when], x, f, self.C[when, some], self.rows, self.size[:, :, when, some])


# The same for all schemes of a form.
@lru_cache(maxsize=8)
def equation_rates(view: Problem, equation: Equation) -> EquationRates:
    """Return the rates at the states that solutions reach.

    Parameters
    ----------
    view : Problem
    equation : Equation
        Of its comparable components.
    """
    t, x = reached_states(view, equation)
    h = COARSE * time_unit(view)
    # Steps of all sizes begin at whole numbers of them, after the first one and before the last.
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
    """Return |f| + |B|/sqrt(unit) and |B|^2 of each component, or unit |f|^2 of one without noise of its own."""
    drift = np.stack([np.linalg.norm(f[:, part], axis=1) for part in rows])
    noise = np.stack([np.linalg.norm(C[..., part, part], axis=(2, 3)) for part in rows])
    speed = drift + np.sqrt(noise / unit)
    typical = np.nanmedian(np.stack([speed, noise]), axis=(2, 3), keepdims=True)
    motion = np.stack([speed, np.where(typical[1] > 0.0, noise, unit * speed**2)])
    size = motion + TYPICAL * np.nanmedian(motion, axis=(2, 3), keepdims=True)
    moved = FINER[-1] * unit * np.linalg.norm(f, axis=1)
    return np.where((size > 0.0) & (moved < MOVED), size, np.inf)


class _Off(NamedTuple):
    # Errors of the rates at S states of each of n times, in parts of their sizes: of the mean, (n, d, S), of the
    # covariance, (n, S, d, d), and how large both are of each component beyond rounding, (2, C, n, S).
    mean: Array
    square: Array
    size: Array

    def of(self, places: Array) -> "_Off":
        return _Off(self.mean[places], self.square[places], self.size[:, :, places])


def _between(a: _Off, b: _Off) -> tuple[Array, Array]:
    return a.mean - b.mean, a.square - b.square


class _ShortSteps(NamedTuple):
    """Steps of a scheme whose law is compared with that of the equation, at two sets of nodes in turn."""

    step: OneStep
    rates: EquationRates
    nodes: tuple[Nodes, Nodes]

    def limits(self) -> tuple[Array, Array]:
        """Return errors of the rates, and whether they have a limit beside 0; both of shape (2, C, n, S)."""
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
        """Return the errors of shorter and shorter steps, until they are seen to fall."""
        found = [first]
        for number, size in enumerate(FINER.tolist(), 1):
            found.append(self._off(asked, size, number % 2))
            if not (found[-1].size > np.fmax(SMALL, FALLING * found[-2].size)).any():
                break
        return found

    def _agreed(self, asked: Array, finest: _Off, wrong: Mask) -> Mask:
        """Return which limits both rules give; none if they differ at many, as they do on a step that jumps."""
        if not wrong.any():
            return wrong
        other, large = self._off(asked, FINER[-1]), finest.size > SMALL
        differ = large & (self._norms(*_between(finest, other)) > AGREEMENT * finest.size)
        return wrong & ~differ if differ.sum() < MANY * large.sum() else np.zeros_like(wrong)

    def _stands(self, asked: Array, found: list[_Off]) -> Mask:
        """Tell where errors have a limit as rates, as moves of the size sqrt(h), or as moves beyond a tolerance."""
        moves = FINER[-1] * self.step.time_unit * self.rates.size[:, :, asked] * found[-2].size
        tolerance = TOLERANCE * np.abs(self.rates.x[asked]).max(axis=1)
        jumps = self._settled(found, 1.0) & (moves > np.stack([tolerance, tolerance**2])[:, None])
        return np.asarray(jumps | self._settled(found, 0.5) | self._settled(found, 0.0))

    def _settled(self, found: list[_Off], power: float) -> Mask:
        """Tell where h^power times the last three errors has settled, and that of coarse steps is no smaller."""
        scaled = [_Off(*(size**power * part for part in off)) for size, off in zip(LAST, found[-4:], strict=True)]
        *fine, coarse = scaled
        changes = [self._norms(*_between(a, b)) for a, b in pairwise(fine)]
        least = fine[-1].size
        settled = (np.fmax(*changes) <= SETTLED * least) & (coarse.size > 0.5 * least)
        return np.asarray(settled & (found[-2].size > SMALL))

    def _off(self, places: Array, part: float, which: int = 0) -> _Off:
        """Return by which parts drift and covariance are off at some of the times, for steps of one size."""
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
        """Return by how much steps move the states, shape (n, S, d, K)."""
        (_, d, S), count = self.rates.x.shape, len(nodes.weights)
        moved = [self.step.read(made.state) - x for x, made in self._made(places, nodes, h)]
        return np.moveaxis(np.reshape(moved, (len(places), d, S, count)), 1, 2)

    def _truncated(self, places: Array) -> Mask:
        """Tell from which states the shortest steps are truncated by some noise, (n, S): they have no limit yet."""
        nodes, S, h = self.nodes[-1], self.rates.x.shape[-1], FINER[-1] * self.step.time_unit
        noise, times = nodes.increment(h, S), self.rates.t[places].tolist()
        masks = [
            self.step.leaves_domain(x, t, h, noise) | (False if made.truncated is None else made.truncated)
            for t, (x, made) in zip(times, self._made(places, nodes, h), strict=True)
        ]
        return np.array([mask.reshape(S, -1).any(axis=1) for mask in masks])

    def _made(self, places: Array, nodes: Nodes, h: float) -> Iterator[tuple[Array, Step]]:
        """Return the states of each time, once for each node, shape (d, S K), and the step from them."""
        noise = nodes.increment(h, self.rates.x.shape[-1])
        wide = np.repeat(self.rates.x[places], len(nodes.weights), axis=2)
        batches = [PathBatch(x, t, h, noise) for t, x in zip(self.rates.t[places].tolist(), wide, strict=True)]
        return zip(wide, self.step.together(batches), strict=True)

    def _norms(self, mean: Array, square: Array) -> Array:
        """Return the sizes of errors of the rates of each component, shape (2, C, n, S)."""
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
    """Return the first components of a state, shape (d,), in words."""
    return f"[{', '.join(f'{value:.3g}' for value in x[:4])}{', ...' if len(x) > 4 else ''}]"
