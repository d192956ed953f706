"""What a scheme's own means are, without sampling: of quadratic observables, on linear equations with a delay.

A quadratic phi has the mean that it has on any points with the same first two moments, for example, with
L L^T = E z z^T - m m^T and k rows,

    E phi(z) = 1/(2 k) sum_i [phi(m + sqrt(k) L_i) + phi(m - sqrt(k) L_i)] .
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, DelayState, Problem, Scheme
from sdaeverify.contracts.scheme import flatten
from sdaeverify.errors import FAULTS
from sdaeverify.forms import Delayed
from sdaeverify.probe.linear.affine import AFFINE, relative
from sdaeverify.probe.linear.delay_equation import at_rest, is_autonomous, is_scalar, linear_delay
from sdaeverify.probe.linear.delay_step import LinearDelayStep, RunMoments, probe_step, run_moments, run_start
from sdaeverify.probe.stability.delay_radius import radius
from sdaeverify.probe.step.nodes import SEED
from sdaeverify.studying import match

from .experiment import SchemeMean, SchemeValue

# Lines along which an observable is differenced.
LINES = 8


class LongRunGrowth(NamedTuple):
    """How second moments grow in the long run.

    Attributes
    ----------
    factor : float
        Of a step of the scheme: its spectral radius.
    rate : float
        Of the equation, as e^(rate t); NaN if it is not known.
    """

    factor: float
    rate: float


class LinearRun(NamedTuple):
    """A scheme with one step size on a linear equation with a delay.

    Attributes
    ----------
    scheme : Scheme
    view : Delayed
        As the scheme sees the equation.
    h : float
    step : LinearDelayStep
    """

    scheme: Scheme
    view: Delayed
    h: float
    step: LinearDelayStep

    def moments(self, steps: int) -> RunMoments:
        """Return means and second moments of x and y up to so many steps."""
        start = run_start(self.scheme, self.view, self.h, steps)
        return run_moments(self.step, self.view.mesh(self.h), start, steps)

    def growth(self) -> LongRunGrowth:
        """Return how second moments grow; the equation's rate is known of one x and one noise."""
        rate = linear_delay(self.view).growth_rate if is_scalar(self.view) else np.nan
        return LongRunGrowth(radius(self.step, self.view.mesh(self.h)).rho, rate)


def linear_run(scheme: Scheme, steps: int, problem: Problem) -> LinearRun | None:
    """Return the run of a scheme with so many steps to the final time; None where it is not linear.

    Parameters
    ----------
    scheme : Scheme
    steps : int
        From 0 to the horizon.
    problem : Problem
        With or without a delay.
    """
    matched, h = match(scheme, problem).problem, problem.horizon / steps
    view = None if matched is None else matched.capability(Delayed)
    if view is None or scheme.law.clip:
        return None
    memory = flatten(scheme.start(view, 1, h))
    if len(memory) != view.dimension + view.constraints or not at_rest(view) or not is_autonomous(view):
        return None
    found = probe_step(scheme, view, h)
    linear = not found.failed and max(found.defect, np.abs(found.offset).max()) <= AFFINE
    return LinearRun(scheme, view, h, found.step) if linear else None


def scheme_means(
    problem: Problem, values: Sequence[SchemeValue], schemes: Mapping[str, Scheme]
) -> Mapping[SchemeValue, SchemeMean]:
    """Return the exact means of those values that have one.

    Parameters
    ----------
    problem : Problem
    values : sequence of SchemeValue
    schemes : mapping of str to Scheme
        By label.

    Returns
    -------
    mapping of SchemeValue to SchemeMean
        Without the values of a run that is not linear, or of an observable that is not quadratic.
    """
    found: dict[SchemeValue, SchemeMean] = {}
    for scheme, steps in dict.fromkeys((value.scheme, value.steps) for value in values):
        own = [value for value in values if (value.scheme, value.steps) == (scheme, steps)]
        # A step that cannot be made at states of its own choice has no known mean; its samples stand.
        with suppress(*FAULTS), np.errstate(all="ignore"):
            run = linear_run(schemes[scheme], steps, problem)
            if run is not None:
                found |= _means(run, problem, [value for value in own if _is_quadratic(run, problem, value)])
    return found


def _means(run: LinearRun, problem: Problem, values: Sequence[SchemeValue]) -> dict[SchemeValue, SchemeMean]:
    moments, growth = run.moments(max((value.at for value in values), default=0)), run.growth()
    return {
        value: SchemeMean(_mean(run, problem, value, (moments.mean[value.at], moments.second[value.at])), *growth)
        for value in values
    }


def _mean(run: LinearRun, problem: Problem, value: SchemeValue, moments: tuple[Array, Array]) -> float:
    mean, second = moments
    size, directions = np.linalg.eigh(second - np.outer(mean, mean))
    # Of a y that x determines there is no variance of its own, and rounding may give it a negative one.
    L = directions * np.sqrt(len(mean) * np.maximum(size, 0.0))
    return float(_evaluate_observable(run, problem, value, mean[:, None] + np.concatenate([L, -L], axis=1)).mean())


def _evaluate_observable(run: LinearRun, problem: Problem, value: SchemeValue, z: Array) -> Array:
    d, t = run.view.dimension, problem.horizon * (value.at / value.steps)
    parts = run.scheme.parts(run.view, DelayState(z[:d], z[d:]))
    return problem.observables[value.observable](t, parts)


def _is_quadratic(run: LinearRun, problem: Problem, value: SchemeValue) -> bool:
    """Tell whether third differences along random lines are rounding."""
    if value.observable not in problem.observables:
        return False
    rng = np.random.Generator(np.random.Philox(key=SEED + 8))
    start, along = rng.standard_normal((2, run.step.rows, LINES))
    at = np.stack([_evaluate_observable(run, problem, value, start + i * along) for i in range(4)])
    third = np.array([-1.0, 3.0, -3.0, 1.0]) @ at
    return relative(third, np.abs(at).max(axis=0)) <= AFFINE
