"""Errors of means at the final time and under the stationary law, from powers of the transition operator.

Every law is represented by the means of basis functions: phi(z_0) T^N after N steps, and pi with
pi T = pi in the limit. Exact means are those declared by the problem, or else phi(z_0) exp(t G) with the
generator G in the same basis. All means are computed in two bases, whose difference is the error bound.

A polynomial basis reaches about ten scales far. If a step is irregular there (blown up, without root, truncated,
heating) or not smooth, the two bases differ, at least at large step sizes, and such errors are not used. If
truncation reduces friction but not noise, the stationary law has tails |v|^-q with q ~ 1/h, and few moments.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Problem
from ...forms.chart import Angle, Line
from ...forms.truths import InvariantMean, Moment
from ...numerics.newton import SOLVED
from ...numerics.statistics import EPS
from ..step.one_step import OneStep
from .basis import Basis, chart_basis
from .chart_equation import generator, output_rows, require_chart
from .transition import ASKED, Given, stationary, transition

# Numbers of functions of an angle and of a coordinate on the line, by the number of coordinates: more for a single
# angle.
FINE, COARSE = {1: (65, 24), 2: (25, 24)}, {1: (49, 18), 2: (19, 18)}
Sizes = Mapping[int, tuple[int, int]]
# Noise nodes per normal left out in the coarse basis.
# Size: nodes of the coarse basis.
FEWER = 2
# Step size and variance with which all means change, except those fixed by a symmetry.
WRONG: Given = (1.1, 1.3)
# Rounding of one application of the operator, in units of EPS and of the size of the observable.
# Rounding: EPS for each operation.
ROUNDING = 64.0
# Number of step sizes that decide together: at one of them, bases may agree by chance.
# Theorem: elementary, a local order needs two step sizes, and its change a third.
NEEDED = 3


BY_STEP_SIZE = ("h", "steps", "errors", "resolution", "departure", "failed", "truncated")


class TransitionErrors(NamedTuple):
    """Errors of the means of O observables at H step sizes.

    Attributes
    ----------
    h, steps : ndarray, shape (H,)
        Step sizes, and numbers of steps over which an error accumulates: to the final time, or in a relaxation
        time (to the horizon if that is unknown).
    errors : ndarray, shape (H, O)
        Signed errors of the scheme's means.
    exact : ndarray, shape (O,)
    spread : ndarray, shape (O,)
        Root mean square of each observable under the law of the basis, the size of the projected function.
    resolution : ndarray, shape (H, O)
        Differences of the errors between the two bases.
    response : ndarray, shape (O,)
        Changes of the scheme's means at the finest step size if it receives too much noise and too long steps: a mean
        that does not change is fixed by a symmetry.
    departure, failed, truncated : ndarray, shape (H,)
        As in `Transition`.
    still : ndarray, shape ()
        1 if a step of the finest size returns its state unchanged, else 0.
    """

    h: Array
    steps: Array
    errors: Array
    exact: Array
    spread: Array
    resolution: Array
    response: Array
    departure: Array
    failed: Array
    truncated: Array
    still: Array = np.zeros(())

    @property
    def sizes(self) -> Array:
        """Sizes of the observables, shape (O,): the larger of |exact mean| and root mean square."""
        return np.asarray(np.maximum(self.spread, np.abs(self.exact)))

    @property
    def floors(self) -> Array:
        """Bounds of the uncertainty of the errors, shape (H, O).

        They are the difference of the two bases plus the effect of failed and truncated steps, their number times the
        size of the observable. The maximum over this and the next two finer step sizes is taken, because at one of
        them bases may agree by chance. Rounding errors of all steps are added.
        """
        disturbed = self.steps * (self.failed + self.truncated)
        floors = self.resolution + np.outer(disturbed, self.sizes)
        rounding = np.outer(ROUNDING * EPS * self.steps, self.sizes)
        finer = np.pad(floors, [(0, NEEDED - 1), (0, 0)])
        return np.asarray(np.lib.stride_tricks.sliding_window_view(finer, NEEDED, axis=0).max(axis=-1) + rounding)

    @property
    def why_not_evidence(self) -> str:
        """That the scheme leaves the chart, which makes the record invalid; empty if it does not."""
        worst = int(np.argmax(self.departure))
        if self.departure[worst] > SOLVED:
            return f"the scheme leaves the chart, by {self.departure[worst]:.1g} at h = {self.h[worst]:.3g}"
        return ""

    def extend(self, finer: "TransitionErrors") -> "TransitionErrors":
        """Return the record extended by a record of finer step sizes."""
        both = {name: np.concatenate([getattr(self, name), getattr(finer, name)]) for name in BY_STEP_SIZE}
        return self._replace(**both, response=finer.response)


# Means of all functions under a law, and the diagnostics of its steps.
_Law = tuple[Array, tuple[float, float, float]]


class _Question(NamedTuple):
    # Means to compute, of O observables at H step sizes: the scheme's law and the diagnostics of its steps as a
    # function of (number of steps, arguments of `transition`), and the exact means as a function of (basis,
    # coefficients of the observables).
    one_step: OneStep
    names: tuple[str, ...]
    h: Array
    steps: Array
    law: Callable[..., _Law]
    exact: Callable[[Basis, Array], Array]


def chart_observables(view: Problem) -> tuple[str, ...]:
    """Return the names of the observables that are functions of the chart, in the problem's order."""
    return tuple(name for name in view.observables if _is_function(view, name))


def invariant_observables(view: Problem) -> tuple[str, ...]:
    """Return the names of the chart observables with a known invariant mean."""
    known = {truth.observable for truth in view.truths if isinstance(truth, InvariantMean)}
    return tuple(name for name in chart_observables(view) if name in known)


def weak_errors(scheme: Scheme, view: Problem, steps: Sequence[int]) -> TransitionErrors:
    """Return the errors of the means of `chart_observables` at the final time, from the problem's initial state.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_operator` is empty for the pair.
    steps : sequence of int
        Numbers of steps to the final time.

    Returns
    -------
    TransitionErrors
    """
    (ito, chart), T = require_chart(view), view.horizon
    start = chart.read(ito.initial(1))

    def law(count: int, one_step: OneStep, basis: Basis, *how: Any) -> _Law:
        step, means = transition(one_step, basis, *how), basis.values(start)[:, 0]
        for _ in range(count):
            means = means @ step.matrix
        return means, step.noticed

    def exact(basis: Basis, functions: Array) -> Array:
        if all(name in truths for name in names):
            return np.array([truths[name] for name in names])
        means = basis.values(start)[:, 0] @ scipy.linalg.expm(T * generator(ito, chart, basis)) @ functions
        return np.array([truths.get(name, mean) for name, mean in zip(names, means, strict=True)])

    names = chart_observables(view)
    truths = {truth.observable: truth.value(T) for truth in view.truths if isinstance(truth, Moment)}
    counts = np.array(steps, dtype=float)
    return _answer(_Question(OneStep(scheme, view), names, T / counts, counts, law, exact))


def invariant_errors(
    scheme: Scheme, view: Problem, step_sizes: Sequence[float], bases: tuple[Sizes, Sizes] = (FINE, COARSE)
) -> TransitionErrors:
    """Return the errors of the means of `invariant_observables` under the stationary law.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_operator` is empty for the pair.
    step_sizes : sequence of float
    bases : tuple of mapping of int to tuple of int, optional
        Sizes of the fine and of the coarse basis, as in `FINE` and `COARSE`.

    Returns
    -------
    TransitionErrors
    """

    def law(_: int, *how: Any) -> _Law:
        return _stationary_law(*how)

    def exact(_: Basis, __: Array) -> Array:
        return np.array([truths[name] for name in names])

    names = invariant_observables(view)
    truths = {truth.observable: truth.value for truth in view.truths if isinstance(truth, InvariantMean)}
    h = np.array(step_sizes)
    counts = (view.relaxation_time if np.isfinite(view.relaxation_time) else view.horizon) / h
    return _answer(_Question(OneStep(scheme, view), names, h, counts, law, exact), bases)


def _answer(question: _Question, bases: tuple[Sizes, Sizes] = (FINE, COARSE)) -> TransitionErrors:
    _, chart = require_chart(question.one_step.view)
    # Overflow gives non-finite values, which the record keeps.
    with np.errstate(all="ignore"):
        large, small = (chart_basis(chart, *sizes[len(chart.axes)]) for sizes in bases)
        errors, exact, spread, noticed = _means(question, large)
        coarse, *_ = _means(question, small, FEWER)
        finest = question._replace(h=question.h[-1:], steps=question.steps[-1:])
        response = np.abs(_means(finest, small, FEWER, WRONG)[0][0] - coarse[-1])
        difference = np.abs(errors - coarse)
        still = np.array(float(question.one_step.is_still(float(question.h[-1]))))
    record = TransitionErrors(question.h, question.steps, errors, exact, spread, difference, response, *noticed)
    return record._replace(still=still)


def _means(
    question: _Question, basis: Basis, fewer: int = 0, given: Given = ASKED
) -> tuple[Array, Array, Array, Array]:
    """Return errors (H, O), exact means and spreads (O,), and the diagnostics of the steps (3, H), in one basis."""
    values = _evaluate_observables(question.one_step.view, question.names, basis.nodes)
    functions = basis.project(values.T)
    exact = question.exact(basis, functions)
    sizes = zip(question.steps, question.h, strict=True)
    found = [question.law(round(n), question.one_step, basis, h, fewer, given) for n, h in sizes]
    laws, noticed = zip(*found, strict=True)
    errors = np.array(laws) @ functions - exact
    return errors, exact, np.sqrt(values**2 @ basis.weights), np.array(noticed).T


@lru_cache(maxsize=32)
def _stationary_law(one_step: OneStep, basis: Basis, h: float, fewer: int, given: Given) -> _Law:
    # Cached, because densities need the same steps.
    step = transition(one_step, basis, h, fewer, given)
    return stationary(step.matrix), step.noticed


def _evaluate_observables(view: Problem, names: Sequence[str], z: Array, outputs: float = 0.0) -> Array:
    # Return the observables at coordinates z, shape (O, P), with rows of pure outputs set to `outputs`.
    ito, chart = require_chart(view)
    moved = outputs * output_rows(ito, chart, z)[:, None] if outputs else 0.0
    parts = ito.parts(chart.embed(z) + moved)
    values = [np.broadcast_to(view.observables[name](view.horizon, parts), z.shape[1:]) for name in names]
    return np.array(values).reshape(len(names), z.shape[1])


def _is_function(view: Problem, name: str) -> bool:
    _, chart = require_chart(view)
    z = chart_basis(chart, 5, 4).nodes
    turn = np.array([2.0 * np.pi if isinstance(axis, Angle) else 0.0 for axis in chart.axes])[:, None]
    values = _evaluate_observables(view, [name], z)
    others = (_evaluate_observables(view, [name], z + turn), _evaluate_observables(view, [name], z, 1.0))
    # One that changes by more, for a full turn of an angle or another pure output, is no function of the chart.
    bound = SOLVED * (1.0 + np.abs(values))
    return bool(np.isfinite(values).all() and all(np.all(np.abs(other - values) <= bound) for other in others))


# Densities of the stationary law for each coordinate. For means m_j of the orthonormal functions phi_j of a
# coordinate, with w the density for which they are orthonormal, the density is w sum_j m_j phi_j. For two
# coordinates, the means of functions of one of them give its marginal law.


# Size: points of a line.
POINTS = 41
# On a line, densities are evaluated up to this number of scales from the centre.
# Size: range of points.
REACH = 5.0
# An expansion whose negative part exceeds this part of its maximum does not represent the density.
# Words: which densities are shown, and no verdict.
NEGATIVE = 0.01


class Densities(NamedTuple):
    """Densities of K coordinates at P points each.

    Attributes
    ----------
    h : ndarray, shape ()
        Step size.
    at, scheme, exact : ndarray, shape (K, P)
        Values of the coordinates, and the stationary densities of the scheme and of the equation.
    """

    h: Array
    at: Array
    scheme: Array
    exact: Array

    @property
    def resolved(self) -> bool:
        """Whether the basis represents both laws: densities are finite, and nonnegative up to `NEGATIVE`."""
        both = np.stack([self.scheme, self.exact])
        return bool(np.isfinite(both).all() and np.all(both.min(axis=-1) >= -NEGATIVE * both.max(axis=-1)))


def stationary_densities(scheme: Scheme, view: Problem, h: float) -> Densities:
    """Return the stationary densities of a scheme, and of the equation by its generator.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_operator` is empty for the pair.
    h : float
        Step size.

    Returns
    -------
    Densities
        NaN if a law is unknown.
    """
    _, chart = require_chart(view)
    basis = chart_basis(chart, *FINE[len(chart.axes)])
    with np.errstate(all="ignore"):
        own, _ = _stationary_law(OneStep(scheme, view), basis, h, 0, ASKED)
        exact = _invariant(view, basis)
        at = np.array([_points(axis) for axis in chart.axes])
        found = [np.array(list(_marginals(basis, law, chart.axes, at))) for law in (own, exact)]
    return Densities(np.array(h), at, *found)


# Cached, as it is the same for all schemes of a form and all step sizes.
@lru_cache(maxsize=4)
def _invariant(view: Problem, basis: Basis) -> Array:
    """Return pi with pi G = 0 and pi(1) = 1."""
    G = generator(*require_chart(view), basis)
    return stationary(np.eye(len(G)) + G)


def _points(axis: Angle | Line) -> Array:
    if isinstance(axis, Angle):
        return np.linspace(-np.pi, np.pi, POINTS)
    return axis.centre + axis.scale * np.linspace(-REACH, REACH, POINTS)


def _marginals(basis: Basis, law: Array, axes: tuple[Angle | Line, ...], at: Array) -> Iterator[Array]:
    means = law.reshape(len(basis.axes[0].derivative), -1)
    for axis, own, functions, y in zip(axes, (means[:, 0], means[0]), basis.axes, at, strict=False):
        yield _weight(axis, y) * (own @ functions.values(y))


def _weight(axis: Angle | Line, y: Array) -> Array:
    if isinstance(axis, Angle):
        return np.full(y.shape, 0.5 / np.pi)
    x = (y - axis.centre) / axis.scale
    return np.asarray(np.exp(-0.5 * x**2) / (np.sqrt(2.0 * np.pi) * axis.scale))
