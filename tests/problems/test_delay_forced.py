"""The equation whose constraint depends on time: its moments, and the bug that no other delay problem shows."""

import numpy as np
import pytest

from schemes.delay_cells import H
from sdaeverify import DelaySDAE, Moment
from sdaeverify.arrays import Array
from sdaeverify.contracts.scheme import Scheme
from sdaeverify.forms.delay.delay_sdae import DelayState
from sdaeverify.noise.brownian import Increment
from sdaeverify_planted.delay_theta import OldTimeAlgebraic
from sdaeverify_problems.delay_forced import delay_forced
from sdaeverify_problems.delay_ou import delay_ou
from sdaeverify_problems.delay_test import delay_test
from sdaeverify_schemes.stochastic_theta import StochasticTheta

OTHER = {"a": -0.3, "B": 0.4, "q": -0.7, "amplitude": 1.3, "omega": 1.7, "sigma": 0.4, "tau": 0.6}


def known(problem: DelaySDAE, name: str, t: float) -> float:
    """Return a moment at some time, that of the history where it is before 0."""
    if t <= 0.0:
        return float(problem.past(t)[0, 0])
    return next(m.value(t) for m in problem.truths if isinstance(m, Moment) and m.observable == name)


@pytest.mark.parametrize("parameters", [{}, OTHER], ids=["shipped", "other"])
@pytest.mark.parametrize("part", [0.13, 0.45, 0.8])
def test_means_solve_the_equation_and_its_constraint(parameters: dict[str, float], part: float) -> None:
    """By differences of the declared E x, and by the problem's own drift and constraint at it."""
    problem = delay_forced(**parameters)
    t, e = part * problem.horizon, 1e-3
    x, v, y = (np.array([[known(problem, name, s)]]) for name, s in (("x", t), ("x", t - problem.delay), ("y", t)))
    assert problem.constraint is not None

    rate = (known(problem, "x", t + e) - known(problem, "x", t - e)) / (2.0 * e)

    assert problem.drift(t, x, v, y)[0, 0] == pytest.approx(rate, abs=1e-5)
    assert problem.constraint(t, x, v, y)[0, 0] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("t", [0.4, 1.3, 2.0])
def test_higher_moments_are_those_of_a_normal_law_with_the_variance_without_force(t: float) -> None:
    """A force that knows no noise moves the mean alone."""
    problem, free = delay_forced(), delay_ou(A=-0.5, B=-1.0)
    mean, variance = known(problem, "x", t), known(free, "x^2", t) - known(free, "x", t) ** 2

    assert known(problem, "x^2", t) == pytest.approx(mean**2 + variance, rel=1e-12)
    assert known(problem, "x^3", t) == pytest.approx(mean**3 + 3.0 * mean * variance, rel=1e-12)


def after_a_step(scheme: Scheme, problem: DelaySDAE) -> Array:
    """Return y after a step from the middle of the run."""
    rng = np.random.default_rng(4)
    x, lagged, ahead = rng.standard_normal((3, 1, 5))
    noise = Increment(np.sqrt(H) * rng.standard_normal((1, 5)), None, lagged=lagged, ahead=ahead)
    t = 0.5 * problem.horizon
    state: DelayState = scheme.prepare(problem, H)(problem.consistent(t, x, lagged), t, noise).state
    return state.y


def test_a_constraint_of_the_old_time_shows_where_it_depends_on_time_alone() -> None:
    """Elsewhere the bug is the right step: it survived on every delay problem but this one."""
    differences = [
        np.abs(after_a_step(OldTimeAlgebraic(), problem) - after_a_step(StochasticTheta(), problem))
        for problem in (delay_test(), delay_forced())
    ]
    assert differences[0].max() < 1e-14
    assert differences[1].min() > 1e-3
