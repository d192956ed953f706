"""Global weak orders by propagated moments: errors in closed form, orders, and what has none."""

import numpy as np
import pytest

from cells import Rule
from facade import (
    SRA1,
    BalancedEuler,
    EulerMaruyama,
    MomentErrors,
    PlatenWeak2,
    StochasticTheta,
    double_well,
    forced_ou,
    gbm,
    least_order,
    linear_test,
    moment_orders,
    noncommuting,
    ou,
)
from probe import linear_cells as c
from sdaeverify import SDE, Array, Increment, Problem, Scheme
from sdaeverify.measuring import packed, unpacked
from sdaeverify.probe.linear.linear_map import REACHED
from sdaeverify.probe.step.step_noise import SCATTERED
from sdaeverify.probing import moment_errors, why_not_moments

STEPS = (8, 16, 32, 64, 128, 256)
# What is propagated, six finer step sizes included.
ALL_STEPS = tuple(8 * 2**level for level in range(12))


def errors(scheme: Scheme, problem: Problem, steps: tuple[int, ...] = STEPS) -> MomentErrors:
    """Return the errors of moments after they were stored."""
    view = problem.view(scheme.form)
    assert view is not None
    assert why_not_moments(scheme, view) == ""
    record = unpacked("moments", MomentErrors, packed("moments", moment_errors(scheme, view, steps)))
    assert record is not None
    return record


def least(record: MomentErrors) -> tuple[float, float]:
    """Return the interval of the least order of all moments."""
    return least_order(moment_orders(record))


def test_errors_of_euler_on_growth_are_those_of_two_powers() -> None:
    """(1 + a h)^N - e^a and ((1 + a h)^2 + b^2 h)^N - e^(2a + b^2), within the floor."""
    record, n = errors(EulerMaruyama(), gbm(0.5, 0.6)), np.array(ALL_STEPS)
    first = (1 + 0.5 / n) ** n - np.exp(0.5)
    second = ((1 + 0.5 / n) ** 2 + 0.36 / n) ** n - np.exp(1.36)
    assert (np.abs(record.first[:, 0] - first) < record.floor).all()
    assert (np.abs(record.second[:, 0, 0] - second) < record.floor).all()
    assert (record.floor[:6] < 1e-11).all()
    assert (record.h == 1.0 / n).all()


def test_errors_of_euler_on_an_additive_equation_are_those_of_a_recursion() -> None:
    """The mean (1 - h)^N and the second moment of the recursion P <- (1 - h)^2 P + sigma^2 h."""
    record = errors(EulerMaruyama(), ou(1.0, 0.7))
    for level, n in enumerate(STEPS):
        h, P = 1.0 / n, 1.0
        for _ in range(n):
            P = (1 - h) ** 2 * P + 0.49 * h
        exact = np.exp(-2.0) + 0.245 * (1 - np.exp(-2.0))
        assert record.first[level, 0] == pytest.approx((1 - h) ** n - np.exp(-1.0), abs=record.floor[level])
        assert record.second[level, 0, 0] == pytest.approx(P - exact, abs=record.floor[level])


CORRECT: dict[str, tuple[Scheme, Problem, float]] = {
    "euler on growth": (EulerMaruyama(), gbm(), 1.0),
    "euler on two noises": (EulerMaruyama(), noncommuting(), 1.0),
    "trapezoidal rule on ou": (StochasticTheta(), ou(), 2.0),
    "three-point variables": (PlatenWeak2(), gbm(), 2.0),
    "sra1, which uses areas": (SRA1(), ou(), 2.0),
    "a two-step scheme": (c.AdamsBashforth(), gbm(), 1.0),
}


@pytest.mark.sweep
@pytest.mark.parametrize("name", CORRECT)
def test_orders_of_correct_schemes_are_found(name: str) -> None:
    """Euler 1, the trapezoidal rule 2 where the noise is additive, schemes of weak order 2, and memory."""
    scheme, problem, order = CORRECT[name]
    assert least(errors(scheme, problem)) == pytest.approx((order, order), abs=0.04)


def test_two_batches_of_each_step_size_are_all_that_is_evaluated() -> None:
    """For Euler on a scalar equation, at few states and nodes, independent of the number of steps."""
    batches: list[int] = []

    def counted(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        batches.append(x.shape[1])
        return c.euler(problem, x, h, noise)

    moment_errors(c.Formula(counted), gbm(), STEPS)
    assert len(batches) == 2 * len(ALL_STEPS)
    # Two states at two nodes decide; four more, reached ones and twelve more nodes check that the step is linear, and
    # one state at random noise that the nodes are enough.
    assert set(batches) == {(2 + 4 + REACHED) * 14, SCATTERED}


def test_steps_that_miss_a_growing_moment_have_no_order_that_is_too_low() -> None:
    """A balanced step of weak order 1/2 finds next to nothing of E x^2 = e^105 with b^2 h from 16 to 1/64."""
    record = errors(BalancedEuler(), linear_test(b=5.0, horizon=5.0))
    found = moment_orders(record)[-1]
    assert found.order < 0.01
    assert found.high == np.inf
    assert "still changes" in found.note


def scaled(drift: float, noise: float) -> Scheme:
    def rule(problem: SDE, x: Array, h: float, increment: Increment) -> Array:
        change = c.euler(problem, x, h, increment) - x
        f = h * problem.drift(0.0, x)
        return x + drift * f + noise * (change - f)

    return c.Formula(rule)


@pytest.mark.sweep
@pytest.mark.parametrize("problem", [gbm(), ou(), noncommuting()], ids=["growth", "ou", "two noises"])
@pytest.mark.parametrize(("drift", "noise"), [(0.98, 1.0), (1.0, 1.025), (1.0, 1.005), (1.0, 1.0005)])
def test_schemes_with_a_wrong_limit_have_no_order_one(problem: SDE, drift: float, noise: float) -> None:
    """Drift too small by 2 per cent, variance too large by up to 5 per cent: some moment does not converge."""
    assert least(errors(scaled(1.0, 1.0), problem)) == pytest.approx((1.0, 1.0), abs=0.04)
    assert least(errors(scaled(drift, noise), problem))[1] < 0.1


def test_a_scheme_that_is_exact_for_two_moments_shows_no_error() -> None:
    """The exact law of ou: all is rounding, and the order is infinite."""

    def exact(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return np.exp(-h) * x + 0.7 * np.sqrt(-np.expm1(-2.0 * h) / (2.0 * h)) * noise.dW

    assert least(errors(c.Formula(exact), ou())) == (np.inf, np.inf)


@pytest.mark.parametrize("rule", [c.tamed, c.implicit_in_noise], ids=["not linear", "a pole"])
def test_steps_without_moments_have_no_order(rule: Rule) -> None:
    """Neither a step that is not linear nor one whose second moment is infinite."""
    assert least(errors(c.Formula(rule), c.linear(-1.0, [0.5]))) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("problem", "reason"),
    [
        (double_well(), "not linear"),
        (forced_ou(), "depends on time"),
        (c.linear(-np.eye(30), [0.1 * np.eye(30)]), "too many"),
    ],
)
def test_problems_without_moment_equations_are_refused(problem: SDE, reason: str) -> None:
    """Curved ones, ones that depend on time, and large ones."""
    assert reason in why_not_moments(EulerMaruyama(), problem)
