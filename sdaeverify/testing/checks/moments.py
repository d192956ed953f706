"""Checks of the known expectations of a problem: at time 0, over the horizon, and for large times."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.polynomial import Chebyshev

from ...arrays import Array
from ...forms import IndexOne
from ...forms.names import article
from ...forms.truths import InvariantMean, Moment
from ...numerics import norm
from ...numerics.statistics import EPS
from ..check import Inapplicable
from ..subjects import ProblemSubject
from .differences import FIRST_ERROR, SECOND_ERROR, first, second

# Relaxation times until e^{-20} = 2e-9 of the initial deviation is left.
RELAXED, CLOSE = 20.0, 1e-6
# Accuracy of a moment or a drift, in rounding errors of its size.
ROUNDINGS = 16.0
# An interpolation resolves a function if its last coefficients, and its error at time 0, which is not a node, are at
# the level of rounding. The time interval is halved until they are.
DEGREE, LAST, HALVINGS = 10, 3, 32


def moments(subject: ProblemSubject) -> list[Moment]:
    """Return the known moments of a problem.

    Raises
    ------
    Inapplicable
        If the problem has none.
    """
    known = [truth for truth in subject.problem.truths if isinstance(truth, Moment)]
    if not known:
        raise Inapplicable("it knows no moment")
    return known


def check_start(subject: ProblemSubject) -> str:
    """Expect each moment to equal its observable at the start, and to be a finite number at every time."""
    problem = subject.problem
    for moment in moments(subject):
        at_start = problem.observables[moment.observable](0.0, problem.parts(problem.initial(1)))[0]
        values = [moment.value(float(t)) for t in np.linspace(0.0, problem.horizon, 9)]
        if not all(np.ndim(value) == 0 and np.isfinite(value) for value in values):
            return f"the moment of {moment.observable} is not one finite number at every time"
        if not abs(values[0] - at_start) <= ROUNDINGS * EPS * max(1.0, abs(at_start)):
            return (
                f"the moment of {moment.observable} begins with {values[0]:.6g}, the observable with {at_start:.6g}"
            )
    return ""


def check_rate(subject: ProblemSubject) -> str:
    """Expect the initial rate of each moment of an observable q to be Dq f + (1/2) sum_j D^2 q(B_j, B_j).

    Both are compared up to their errors, since the terms of a stiff equation are large and may cancel.
    """
    problem = subject.problem
    x = np.concatenate(list(problem.parts(problem.initial(1)).values()))
    drift, diffusion = _flow(problem, x)
    for moment in moments(subject):
        rate, error = _rate_of_equation(_observable_of_array(subject, moment.observable), x, drift, diffusion)
        given, off = _rate_at_the_start(moment.value, problem.horizon)
        if not abs(rate - given) <= error + off:
            text = f"the moment of {moment.observable} begins with the rate {given:.8g}"
            return f"{text}, the equation with {rate:.8g}"
    return ""


def check_limit(subject: ProblemSubject) -> str:
    """Expect moments to converge to the invariant means of the same observables."""
    problem = subject.problem
    pairs = list(_pairs(subject))
    if not pairs:
        raise Inapplicable("it knows no observable both as a moment and as an invariant mean")
    for moment, mean in pairs:
        late = moment.value(RELAXED * problem.relaxation_time)
        if not abs(late - mean.value) <= CLOSE * max(1.0, abs(mean.value)):
            text = f"after {RELAXED:.0f} relaxation times the moment of {mean.observable} is {late:.8g}"
            return f"{text}, its invariant mean {mean.value:.8g}"
    return ""


def _pairs(subject: ProblemSubject) -> Iterator[tuple[Moment, InvariantMean]]:
    truths = subject.problem.truths
    for mean in (truth for truth in truths if isinstance(truth, InvariantMean)):
        for moment in (truth for truth in truths if isinstance(truth, Moment)):
            if moment.observable == mean.observable and np.isfinite(subject.problem.relaxation_time):
                yield moment, mean


# A number and a bound on its error.
_Known = tuple[float, float]


def _rate_of_equation(q: Callable[[Array], Array], x: Array, drift: Array, diffusion: Array) -> _Known:
    """Return Dq f + (1/2) sum_j D^2 q(B_j, B_j) at x, with the rounding errors of the differences.

    Derivatives are taken in directions of length 1, so that their errors are multiplied by the length of the drift,
    or the squared length of a column. The drift itself is accurate to `ROUNDINGS` rounding errors of its size.
    """
    f, columns = float(norm(drift)[0]), [column for column in np.moveaxis(diffusion, 1, 0) if np.any(column)]
    squares = [float(norm(column)[0]) ** 2 for column in columns]
    values = [f * first(q, x, drift / f)] if f else []
    values += [0.5 * b * second(q, x, column / np.sqrt(b)) for b, column in zip(squares, columns, strict=True)]
    size = 1.0 + abs(float(q(x)[0]))
    error = (FIRST_ERROR + ROUNDINGS * EPS) * f + SECOND_ERROR * (1.0 + sum(squares))
    return float(sum(values, np.zeros(1))[0]), size * error


def _rate_at_the_start(value: Callable[[float], float], horizon: float) -> _Known:
    """Return the derivative at time 0, by interpolation on an interval short enough to resolve the function.

    Expectations need not be analytic at time 0: a singularity at a distance r contributes like e^{-r^2/(2t)}. With
    errors delta of the values, coefficients have errors of at most 2 delta, and the derivative on an interval of
    length s has an error of at most (2/s) sum_k k^2 2 delta.
    """
    known: list[tuple[float, float, float]] = []
    for span in horizon / 32 * 0.5 ** np.arange(HALVINGS):
        line = Chebyshev.interpolate(
            lambda times: np.array([value(float(t)) for t in times]), DEGREE, domain=[0.0, span]
        )
        rounding = ROUNDINGS * EPS * float(np.abs(line.coef).sum())
        unseen = max(float(np.abs(line.coef[-LAST:]).max()), abs(float(line(0.0)) - value(0.0)))
        known.append((max(unseen, rounding), float(span), float(line.deriv()(0.0))))
        if unseen <= rounding:
            break
    delta, span, slope = min(known)
    return slope, 4.0 / span * sum(k * k for k in range(DEGREE + 1)) * delta


def _observable_of_array(subject: ProblemSubject, name: str) -> Callable[[Array], Array]:
    """Return an observable at time 0 as a function of all components in one array."""
    problem = subject.problem
    sizes = {part: len(value) for part, value in problem.parts(problem.initial(1)).items()}
    ends = dict(zip(sizes, np.cumsum(list(sizes.values())), strict=True))

    def value(x: Array) -> Array:
        parts = {part: x[ends[part] - sizes[part] : ends[part]] for part in sizes}
        return np.asarray(problem.observables[name](0.0, parts))

    return value


def _flow(problem: Any, x: Array) -> tuple[Array, Array]:
    """Return drift and diffusion of all named components at time 0, including those of a multiplier."""
    if problem.capability(IndexOne):
        return _delay_flow(problem)
    view = problem.ito()
    if view is None:
        raise Inapplicable(f"{article(type(problem).__name__)} has no Ito equation whose rate could be taken")
    return view.drift(0.0, x), np.broadcast_to(view.diffusion(0.0, x), (len(x), view.noise_dim, 1))


def _rate_beside_x(problem: Any, x: Array) -> Array:
    """Return d/dt U(t, x, v(t)) at time 0 for fixed x = x(0), shape (q, 1)."""

    def component(i: int) -> Callable[[float], float]:
        def value(t: float) -> float:
            return float(problem.eliminated(t, x, problem.past(t - problem.delay) if problem.delay else x)[i, 0])

        return value

    span = min(problem.horizon, problem.delay or np.inf)
    return np.array([[_rate_at_the_start(component(i), span)[0]] for i in range(problem.constraints)])


def _delay_flow(problem: Any) -> tuple[Array, Array]:
    """Return drift and diffusion of x and y = U(t, x, v) at time 0, where v moves along the history."""
    start, v = problem.initial(1), problem.past(-problem.delay)
    f = problem.drift(0.0, start.x, v, start.y)
    g = np.broadcast_to(problem.diffusion(0.0, start.x, v, start.y), (len(f), problem.noise_dim, 1))
    if not problem.constraints:
        return f, g

    def of_x(x: Array) -> Array:
        return np.asarray(problem.eliminated(0.0, x, v if problem.delay else x))

    columns = list(np.moveaxis(g, 1, 0))
    slope = first(of_x, start.x, f) + 0.5 * sum(second(of_x, start.x, column) for column in columns)
    slope = slope + _rate_beside_x(problem, start.x)
    kicks = np.stack([first(of_x, start.x, column) for column in columns], axis=1)
    return np.concatenate([f, slope]), np.concatenate([g, kicks])
