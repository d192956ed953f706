"""Wrong moments and wrong derivatives are noticed, where they show at all."""

import dataclasses

import numpy as np
import pytest

from facade import delay_forced, delay_test, ou, pendulum
from sdaeverify import Moment
from testing.asking import of_problem

RATE = "moments-rate"


def knowing(problem, *moments):
    """Return a problem function that knows these moments alone."""

    def planted():
        """Know what was planted."""
        return dataclasses.replace(problem, truths=moments)

    return planted


@pytest.mark.parametrize("value", [lambda t: 0.25 + 1.05 * t, lambda t: 0.25 + t**2, lambda t: 0.25 * np.exp(t)])
def test_a_wrong_rate_of_a_moment_is_noticed(value):
    """Expectations that start at the right value but not with the right rate fail."""
    moment = Moment(observable="|v|^2", value=value, source="planted")
    family = knowing(pendulum(c_g=0.0), moment)

    assert of_problem(family, "moments-start")["status"] == "passed"
    assert of_problem(family, RATE)["status"] == "failed"


@pytest.mark.parametrize("observable", ["x", "x^2", "y"])
@pytest.mark.parametrize("family", [delay_test, delay_forced])
def test_a_wrong_rate_of_a_moment_with_delay_is_noticed(family, observable):
    """What is added to a moment of x or of y fails, y moving with history and time; the moment itself passes."""
    problem = family(horizon=1.0)
    (known,) = (t for t in problem.truths if isinstance(t, Moment) and t.observable == observable)
    wrong = dataclasses.replace(known, value=lambda t: known.value(t) + 1e-3 * t)

    assert of_problem(knowing(problem, known), RATE)["status"] == "passed"
    assert of_problem(knowing(problem, wrong), RATE)["status"] == "failed"


@pytest.mark.parametrize(
    "label",
    [
        "harmonic-langevin[omega=1000,horizon=0.001]",
        "harmonic-langevin[omega=1000,gamma=1e4]",
        "ou[a=1e6,horizon=1e-5]",
        "noisy-circuit[R_1=1e-6]",
        "stiefel[eps=1e-4]",
    ],
)
def test_right_moments_of_stiff_problems_pass(label):
    """Neither rounding in front of large coefficients nor a fast time far below the horizon is a wrong rate."""
    assert of_problem(label, RATE)["status"] == "passed"


@pytest.mark.parametrize("off", [1e-6, -1e-6])
def test_a_slightly_wrong_rate_of_a_stiff_problem_is_noticed(off):
    """One part in a million of the largest term of the rate fails."""
    problem = ou(a=1e6, horizon=1e-5)
    (known,) = (t for t in problem.truths if isinstance(t, Moment) and t.observable == "x^2")
    wrong = dataclasses.replace(known, value=lambda t: known.value(t * (1.0 + off)))

    assert of_problem(knowing(problem, known), RATE)["status"] == "passed"
    assert of_problem(knowing(problem, wrong), RATE)["status"] == "failed"
