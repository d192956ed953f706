"""The contract of problems refuses wrong derivatives, wrong starts and wrong truths."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from conformance import test_problem_contract as problems
from conformance import test_truth_contract as truths
from conformance.cells import Promise
from sdaeverify.errors import ProblemError
from sdaeverify.forms import Problem
from sdaeverify.specs import ProblemSpec
from sdaeverify.truths import Moment
from sdaeverify_problems import _circle as circle
from sdaeverify_problems.delay_test import delay_test
from sdaeverify_problems.gbm import gbm
from sdaeverify_problems.pendulum import pendulum

CHANGED: dict[str, tuple[Callable[[], Problem], dict[str, object], Callable[[ProblemSpec], None]]] = {
    "shape of an observable": (
        gbm,
        {"observables": {"x": lambda t, s: np.ones(3)}, "truths": ()},
        lambda spec: problems.test_observables_are_numbers_on_each_path(spec, 5),
    ),
    "mean over paths": (
        gbm,
        {"drift": lambda t, x: x - x.mean()},
        problems.test_functions_are_the_same_on_one_path_and_on_many,
    ),
}


@pytest.mark.parametrize("name", CHANGED)
def test_a_planted_fault_is_noticed(name: str) -> None:
    """A shipped problem with one function changed fails the test of this function."""
    family, change, check = CHANGED[name]
    check(ProblemSpec("right", family))
    changed = dataclasses.replace(family(), **change)

    with pytest.raises(AssertionError):
        check(ProblemSpec("wrong", lambda: changed))


@pytest.mark.parametrize(
    ("family", "change"),
    [
        (gbm, {"diffusion_derivative": lambda t, x, y: 0.61 * y[:, None]}),
        (pendulum, {"jacobian": lambda r: r[None]}),
        (pendulum, {"jacobian": lambda r: np.stack([-r[0], -1.5 * r[1] + 0.5 * r[1] ** 2])[None]}),
        (pendulum, {"curvature": lambda r, y, z: -circle.curvature(r, y, z)}),
    ],
)
def test_a_wrong_derivative_is_refused_where_the_problem_is_made(
    family: Callable[[], Problem], change: dict[str, object]
) -> None:
    """A derivative that disagrees with differences, at the start or nearby, makes no problem at all."""
    with pytest.raises(ProblemError, match="disagrees with a difference quotient"):
        dataclasses.replace(family(), **change)


@pytest.mark.parametrize("value", [lambda t: 0.25 + 1.05 * t, lambda t: 0.25 + t**2, lambda t: 0.25 * np.exp(t)])
def test_a_wrong_rate_of_a_moment_is_noticed(value: Callable[[float], float]) -> None:
    """Expectations that start at the right value but not with the right rate fail."""
    moment = Moment(observable="|v|^2", value=value, source="planted")

    with pytest.raises(AssertionError):
        truths.test_promised_moments_start_with_the_rate_of_the_generator(
            Promise(ProblemSpec("pendulum", lambda: pendulum(c_g=0.0)), moment, "planted")
        )


@pytest.mark.parametrize("observable", ["x", "x^2", "y"])
def test_a_wrong_rate_of_a_moment_with_delay_is_noticed(observable: str) -> None:
    """What is added to a moment of x or of y, the latter moving with the history, fails; the moment itself passes."""
    spec = ProblemSpec("delay-test", delay_test, (("horizon", 1.0),))
    (known,) = (t for t in spec.build().truths if isinstance(t, Moment) and t.observable == observable)
    check = truths.test_promised_moments_start_with_the_rate_of_the_generator
    check(Promise(spec, known, "right"))
    wrong = dataclasses.replace(known, value=lambda t: known.value(t) + 1e-3 * t)

    with pytest.raises(AssertionError):
        check(Promise(spec, wrong, "planted"))
