"""Checks of truths against each other and against simulations of the equation, on a fixed sample of paths.

Intervals of means have a level of 1e-6 for the check as a whole: it is divided by the number of means that are
compared (Bonferroni). Noise is drawn by the problem's name, so that the same problem always gets the same answer.
"""

from collections import defaultdict
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtri

from ...arrays import Array, Parts
from ...forms.truths import Moment
from ...numerics.statistics import EPS, tail
from ..check import Inapplicable
from ..problem_subject import ProblemSubject
from .moments import moments
from .solutions import solution
from .walkers import Walker, euler, known, together

LEVEL = 1e-6
# Levels of Euler's scheme, of 16, 64 and 256 steps, and of a solution that has an error of its own.
LEVELS, OWN = (1, 3, 5), 7
PATHS, MANY = 128, 4096
# Euler's strong order is 1/2 at least; a wrong limit has none.
ORDER, MARGIN = 0.5, 0.2
ROUNDING = 1e4 * EPS


class Mean(NamedTuple):
    """A mean of independent values with its standard error."""

    value: float
    se: float

    @classmethod
    def of(cls, values: Array) -> "Mean":
        """Return the mean of values of shape (n,)."""
        return cls(float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values))))


def solution_simulated(subject: ProblemSubject) -> str:
    """Expect Euler's scheme on the same noise to tend to the solution: the distance falls like h^0.3 or faster."""
    truth, problem = solution(subject), subject.problem
    level = 0 if truth.exact and not truth.extra_normals else LEVELS[-1] if truth.exact else OWN
    runs = [euler(problem, each, PATHS) for each in LEVELS]
    reference = known(problem, truth, level, PATHS)
    squares: dict[str, Array] = defaultdict(lambda: np.zeros(len(LEVELS)))
    sizes: dict[str, float] = defaultdict(float)
    for t in together(problem, subject.spec.label, [*runs, reference], PATHS):
        exact = reference.parts(t)
        for name in exact.keys() & runs[0].parts(t).keys():
            squares[name] += [np.mean((run.parts(t)[name] - exact[name]) ** 2) for run in runs]
            sizes[name] = max(sizes[name], float(np.abs(exact[name]).max()))
    if not squares:
        raise Inapplicable("no component of the solution is one of the simulated equation")
    return next((text for name in sorted(squares) if (text := _no_limit(name, squares[name], sizes[name]))), "")


def _no_limit(name: str, squares: Array, size: float) -> str:
    distances = np.sqrt(squares)
    if not np.isfinite(distances[-1]):
        raise Inapplicable("Euler's scheme with 256 steps leaves all bounds")
    if distances[-1] <= ROUNDING * max(1.0, size):
        return ""
    finite = np.isfinite(distances)
    if finite.sum() < 2:
        raise Inapplicable("Euler's scheme with 64 steps leaves all bounds")
    h = -np.array(LEVELS)[finite]
    slope = float(np.polyfit(h, np.log2(np.maximum(distances[finite], EPS * size)), 1)[0])
    if slope >= ORDER - MARGIN:
        return ""
    shown = ", ".join(f"{distance:.3g}" for distance in distances)
    text = f"the distance of {name} from Euler's scheme with 16, 64 and 256 steps is {shown}"
    return f"{text}: it falls like h^{slope:.2f}"


def solution_averaged(subject: ProblemSubject) -> str:
    """Expect means of the solution over 4096 paths to be the moments, within an interval of level 1e-6 in all."""
    truth, problem = solution(subject), subject.problem
    wanted = moments(subject)
    reference = known(problem, truth, 0, MANY)
    quantile, compared = _quantile(2 * len(wanted)), 0
    for t in together(problem, subject.spec.label, [reference], MANY):
        for moment in wanted:
            values = _observed(problem, moment, t, reference.parts(t))
            if values is None or _heavy(values):
                continue
            compared += 1
            mean, expected = Mean.of(values), moment.value(t)
            if abs(mean.value - expected) > quantile * mean.se + ROUNDING * max(1.0, abs(expected)):
                return _apart(f"the solution's {moment.observable}", mean, quantile, expected, t)
    if not compared:
        raise Inapplicable("no moment is one of known components with light tails")
    return ""


def moments_simulated(subject: ProblemSubject) -> str:
    """Expect means of simulations to be the moments, within an interval of level 1e-6 in all and Euler's own bias.

    The bias with 256 steps is at most twice the difference from 64 steps, for every order from 0.3 on.
    """
    problem, wanted = subject.problem, moments(subject)
    coarse, fine = euler(problem, 3, 8 * PATHS), euler(problem, 5, 8 * PATHS)
    quantile, compared = _quantile(4 * len(wanted)), 0
    for t in together(problem, subject.spec.label, [coarse, fine], 8 * PATHS, mirrored=True):
        for moment in wanted:
            values = _pair(problem, moment, t, coarse, fine)
            if values is None:
                continue
            compared += 1
            mean, change = Mean.of(values[1]), Mean.of(values[1] - values[0])
            bias, expected = 2.0 * (abs(change.value) + quantile * change.se), moment.value(t)
            if abs(mean.value - expected) > quantile * mean.se + bias + ROUNDING * max(1.0, abs(expected)):
                return _apart(f"Euler's {moment.observable}", mean, quantile, expected, t)
    if not compared:
        raise Inapplicable("no moment has light tails")
    return ""


def _pair(problem: Any, moment: Moment, t: float, coarse: Walker, fine: Walker) -> list[Array] | None:
    """Return the observable of both simulations as means over mirrored paths; None where tails are heavy."""
    found = [_observed(problem, moment, t, run.parts(t)) for run in (coarse, fine)]
    if any(values is None for values in found):
        return None
    pairs = [values.reshape(2, -1).mean(axis=0) for values in found if values is not None]
    if not all(np.isfinite(values).all() for values in pairs):
        raise Inapplicable("Euler's scheme with 64 steps leaves all bounds")
    return None if _heavy(pairs[1]) else pairs


def _observed(problem: Any, moment: Moment, t: float, parts: Parts) -> Array | None:
    """Return an observable, or None where it asks for components that are not known."""
    try:
        return np.asarray(problem.observables[moment.observable](t, parts))
    except KeyError:
        return None


def _heavy(values: Array) -> bool:
    deviations = np.abs(values - values.mean())
    largest = np.sort(deviations)[::-1][: int(np.sqrt(len(values)))]
    return tail(float(deviations.sum()), float((deviations**2).sum()), largest, len(values)).heavy


def _quantile(means: int) -> float:
    return -float(ndtri(LEVEL / (2 * means)))


def _apart(what: str, mean: Mean, quantile: float, expected: float, t: float) -> str:
    interval = f"{mean.value:.6g} +- {quantile * mean.se:.2g}"
    return f"{what} has the mean {interval} at t = {t:.3g}, where the moment is {expected:.6g}"
