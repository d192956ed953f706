"""Means of schemes without sampling, for quadratic observables on linear equations with a delay.

The mean of a quadratic phi depends only on the first two moments. It is the same on, for example, the points below
with L L^T = E z z^T - m m^T and k rows,

    E phi(z) = 1/(2 k) sum_i [phi(m + sqrt(k) L_i) + phi(m - sqrt(k) L_i)] .
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial

import numpy as np

from sdaeverify import Array, DelayState, Problem, Scheme
from sdaeverify.errors import FAULTS
from sdaeverify.probing import LinearDelayRun
from sdaeverify.studying import match

from .experiment import SchemeMean, SchemeValue


def scheme_means(
    problem: Problem, values: Sequence[SchemeValue], schemes: Mapping[str, Scheme]
) -> Mapping[SchemeValue, SchemeMean]:
    """Return the exact means of those values that have one.

    Parameters
    ----------
    problem : Problem
    values : sequence of SchemeValue
    schemes : mapping of str to Scheme
        Schemes by label.

    Returns
    -------
    mapping of SchemeValue to SchemeMean
        Means, without values of nonlinear runs or of observables that are not quadratic.
    """
    found: dict[SchemeValue, SchemeMean] = {}
    for scheme, steps in dict.fromkeys((value.scheme, value.steps) for value in values):
        own = [value for value in values if (value.scheme, value.steps) == (scheme, steps)]
        # If a step cannot be computed at the required states, the mean is unknown, and samples are used.
        with suppress(*FAULTS), np.errstate(all="ignore"):
            run = _linear_run(schemes[scheme], steps, problem)
            if run is not None:
                found |= _means(run, problem, [value for value in own if _is_quadratic(run, problem, value)])
    return found


def _linear_run(scheme: Scheme, steps: int, problem: Problem) -> LinearDelayRun | None:
    view = match(scheme, problem).problem
    return None if view is None else LinearDelayRun.of(scheme, view, steps)


def _means(run: LinearDelayRun, problem: Problem, values: Sequence[SchemeValue]) -> dict[SchemeValue, SchemeMean]:
    moments, growth = run.moments(max((value.at for value in values), default=0)), run.growth()
    return {
        value: SchemeMean(_mean(run, problem, value, (moments.mean[value.at], moments.second[value.at])), *growth)
        for value in values
    }


def _mean(run: LinearDelayRun, problem: Problem, value: SchemeValue, moments: tuple[Array, Array]) -> float:
    mean, second = moments
    size, directions = np.linalg.eigh(second - np.outer(mean, mean))
    # A component y determined by x adds no variance, so that rounding may give a negative eigenvalue.
    L = directions * np.sqrt(len(mean) * np.maximum(size, 0.0))
    return float(_evaluate_observable(run, problem, value, mean[:, None] + np.concatenate([L, -L], axis=1)).mean())


def _evaluate_observable(run: LinearDelayRun, problem: Problem, value: SchemeValue, z: Array) -> Array:
    d, t = run.view.dimension, problem.horizon * (value.at / value.steps)
    parts = run.scheme.parts(run.view, DelayState(z[:d], z[d:]))
    return problem.observables[value.observable](t, parts)


def _is_quadratic(run: LinearDelayRun, problem: Problem, value: SchemeValue) -> bool:
    known = value.observable in problem.observables
    return known and run.is_quadratic(partial(_evaluate_observable, run, problem, value))
