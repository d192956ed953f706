"""No verdict depends on the units of state and time, though schemes that bound their steps do."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    BAOAB,
    BalancedEuler,
    DriftTruncatedEuler,
    EulerMaruyama,
    ExplicitProjectionEuler,
    Heun,
    TamedEuler,
    double_well,
    frame_of,
    gbm,
    harmonic_langevin,
    judge_strong,
    judge_weak,
    law_departure,
    least_order,
    local_strong,
    local_weak,
    moment_orders,
    noise_departure,
    ou,
    pendulum,
    spiral,
    strong_orders,
    test_functions,
    weak_order,
)
from probe.strong_cells import probed
from probe.weak_cells import scheme
from sdaeverify import SDE, Array, HolonomicSDAE, HolonomicState, Increment, Langevin, Problem, Scheme, Step
from sdaeverify.measuring import Opinion, Verdict
from sdaeverify.numerics import norm
from sdaeverify.probing import OneStep, cloud, moment_errors, why_not_moments
from units import in_units, langevin_in_units, mechanics_in_units

STEPS = (8, 16, 32, 64, 128, 256)


def weak_opinion(of: Scheme, problem: SDE, claim: float) -> Opinion:
    """Return what steps of usual and of shortest size say together."""
    found, shortest = local_weak(of, problem), local_weak(of, problem, shortest=True)
    return judge_weak(weak_order(found, shortest), claim)


def strong_opinion(of: Scheme, problem: SDE, claim: float) -> Opinion:
    """Return the same of paths."""
    return judge_strong(probed(of, problem, shortest=True)[-1], claim)


@pytest.mark.parametrize("problem", [double_well(), gbm()], ids=["double-well", "growth"])
def test_a_tamed_step_in_small_units_is_too_coarse_and_not_wrong(problem: Problem) -> None:
    """With x in units of 1e-8, h |f| is large at every step size that is probed first: nothing can be decided."""
    small = in_units(problem, scale=1e8)

    assert judge_weak(weak_order(local_weak(TamedEuler(), small)), 1.0).verdict is Verdict.REFUTED
    for found in (weak_opinion(TamedEuler(), small, 1.0), strong_opinion(TamedEuler(), small, 0.5)):
        assert found.verdict is Verdict.INCONCLUSIVE
        assert found.final
        assert "the steps of the run are too long" in str(found.reason)


def tamed_noise(problem: SDE, x: Array, t: float, h: float, noise: Increment) -> Array:
    moved = h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
    return x + moved / (1.0 + np.sqrt(h) * norm(x) ** 2)


def hardly_any_noise(problem: SDE, x: Array, t: float, h: float, noise: Increment) -> Array:
    return x + h * problem.drift(t, x) + 0.001 * problem.diffused(t, x, noise.dW)


@pytest.mark.parametrize(("rule", "wrong"), [(tamed_noise, False), (hardly_any_noise, True)])
def test_noise_that_is_tamed_at_every_size_follows_the_equation_later(rule, wrong) -> None:
    """At x = 100 a factor 1/(1 + h^(1/2) |x|^2), which bounds all noise, is small at all sizes; Sabanis 2016."""
    large, of = gbm(x_0=100.0), scheme(rule)

    assert bool(law_departure(of, large)) is wrong
    assert bool(noise_departure(of, large, paths=True)) is wrong


def without_drift(problem: SDE, x: Array, t: float, h: float, noise: Increment) -> Array:
    return x + problem.diffused(t, x, noise.dW)


def too_much_noise(problem: SDE, x: Array, t: float, h: float, noise: Increment) -> Array:
    return x + h * problem.drift(t, x) + 1.01 * problem.diffused(t, x, noise.dW)


def drift_off_by_a_thousandth(problem: SDE, x: Array, t: float, h: float, noise: Increment) -> Array:
    return x + 1.001 * h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)


@pytest.mark.sweep
@pytest.mark.parametrize("units", [{}, {"scale": 1e8}, {"shift": 1e4}, {"time": 1e6}, {"scale": 1e-8, "time": 1e-6}])
@pytest.mark.parametrize("wrong", [without_drift, too_much_noise, drift_off_by_a_thousandth])
def test_what_is_wrong_is_so_in_all_units(wrong, units):
    """Shorter steps excuse no scheme that does not follow the equation, whatever rounding hides there."""
    problem = in_units(double_well(), **units)

    assert weak_opinion(scheme(wrong), problem, 1.0).verdict is Verdict.REFUTED


@pytest.mark.sweep
@pytest.mark.parametrize("units", [{}, {"scale": 1e8}, {"shift": 1e4}, {"time": 1e6}])
@pytest.mark.parametrize("wrong", [without_drift, too_much_noise])
def test_what_is_wrong_along_paths_is_so_in_all_units(wrong, units):
    """The same of strong orders."""
    problem = in_units(double_well(), **units)

    assert strong_opinion(scheme(wrong), problem, 0.5).verdict is Verdict.REFUTED


class TooMuchNoise(ExplicitProjectionEuler):
    """One per cent too much."""

    name: ClassVar[str] = "planted-too-much-noise"
    form: ClassVar[type] = HolonomicSDAE

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=1.01 * noise.dW))


FAR = [{}, {"scale": 1e6}, {"scale": 1e-6}, {"scale": 1e8, "time": 1e7}, {"time": 1e-5}, {"constraint": 1e6}]


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("units", FAR)
def test_mechanics_are_judged_alike_in_all_units(units: dict[str, float]) -> None:
    """Where lengths are 1e6, second derivatives lost their digits, and all schemes were refuted for weak order 1."""
    problem = mechanics_in_units(pendulum(), **units)

    assert strong_opinion(ExplicitProjectionEuler(), problem, 0.5).verdict is Verdict.VERIFIED
    assert weak_opinion(ExplicitProjectionEuler(), problem, 1.0).verdict is not Verdict.REFUTED
    assert strong_opinion(TooMuchNoise(), problem, 0.5).verdict is Verdict.REFUTED
    assert weak_opinion(TooMuchNoise(), problem, 1.0).verdict is Verdict.REFUTED


@pytest.mark.parametrize("units", [units for units in FAR if units.get("time", 1.0) <= 1.0])
def test_states_that_are_probed_are_the_same_in_all_units(units: dict[str, float]) -> None:
    """A multiplier of 1e12 beside lengths of 1e6 left all states at the start."""
    problem = mechanics_in_units(pendulum(), **units)
    moved = np.ptp(cloud(problem, problem.ito()), axis=1)

    assert (moved[:2] > 0.05 * units.get("scale", 1.0)).all()


def test_a_bounded_step_of_a_slow_equation_is_left_open() -> None:
    """In units of 1e7 of time steps that are short for a bounded noise have errors below rounding."""
    slow = langevin_in_units(harmonic_langevin(), scale=1e8, time=1e7).ito()

    for of in (BalancedEuler(), TamedEuler()):
        found = strong_opinion(of, slow, 0.5)
        assert (found.verdict, found.final) == (Verdict.INCONCLUSIVE, True)
    assert strong_opinion(EulerMaruyama(), slow, 1.0).verdict is Verdict.VERIFIED


class LinearFriction(BAOAB):
    """Momenta decay like 1 - gamma h, not like e^{-gamma h}."""

    name: ClassVar[str] = "planted-linear-friction"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        step, n = super().step(problem, state, t, h, noise), problem.noise_dim
        off = np.exp(-problem.friction * h) - (1.0 - problem.friction * h)
        return step._replace(state=np.concatenate([step.state[:n], step.state[n:] - off * state[n:]]))


@pytest.mark.parametrize("units", [{}, {"scale": 1e8, "time": 1e7}, {"scale": 1e-9, "time": 1e-12}])
def test_errors_of_a_momentum_show_beside_large_positions(units: dict[str, float]) -> None:
    """A momentum of 10 beside a position of 1e8 was compared with the latter: a wrong friction was verified."""
    problem = langevin_in_units(harmonic_langevin(), **units)

    assert strong_opinion(BAOAB(), problem, 1.0).verdict is Verdict.VERIFIED
    assert weak_opinion(BAOAB(), problem, 2.0).verdict is Verdict.VERIFIED
    assert weak_opinion(LinearFriction(), problem, 2.0).verdict is Verdict.REFUTED


def test_a_tamed_step_of_a_fast_equation_is_not_refuted() -> None:
    """Its weak order rises from 0.4 to 1 at steps far shorter than those of paths."""
    fast = langevin_in_units(harmonic_langevin(), time=1e-5).ito()

    assert weak_opinion(TamedEuler(), fast, 1.0).final


def test_an_equation_is_linear_only_if_it_is_where_solutions_go() -> None:
    """The cube of a double well with x in units of 1e-8 is below rounding at states of size 1."""
    assert "not linear" in why_not_moments(Heun(), in_units(double_well(), scale=1e8))
    assert why_not_moments(Heun(), in_units(ou(), scale=1e8)) == ""


@pytest.mark.parametrize("scale", [1.0, 1e8])
def test_exact_moments_keep_their_digits_beside_large_constants(scale: float) -> None:
    """A constant force of 1e8 beside rates of order one had moments of the solution off by 3e-8: a wrong limit."""
    pushed = Langevin(
        force=lambda q: -1.06 * scale - q,
        friction=0.5,
        strength=0.25 * scale,
        position=[-0.75 * scale],
        momentum=[-2.0 * scale],
        horizon=1.0,
        source="test",
    )

    found = moment_orders(moment_errors(EulerMaruyama(), pushed.ito(), STEPS))
    told = [moment.order for moment in found if moment.informative]

    assert len(told) >= 3
    # The mean momentum is near a change of sign.
    assert told == pytest.approx([1.0] * len(told), abs=0.1)


def test_a_step_is_linear_only_if_it_is_where_solutions_go() -> None:
    """About a mean of 300 steps of a truncated drift are constant at states near 0, and linear at those near 300."""
    warm = in_units(ou(), shift=300.0)

    assert not moment_errors(DriftTruncatedEuler(), warm, STEPS).linear
    euler = moment_errors(EulerMaruyama(), warm, STEPS)
    assert euler.linear
    assert least_order(moment_orders(euler)) == pytest.approx((1.0, 1.0), abs=0.04)


@pytest.mark.parametrize("problem", [gbm(), ou(), spiral()], ids=["growth", "ou", "spiral"])
def test_moments_of_a_long_run_are_asked_of_steps_in_the_unit_of_time(problem: Problem) -> None:
    """A balanced step divides by 1 + |dW|, and tells its order from steps that are short beside 1."""
    low, high = least_order(moment_orders(moment_errors(BalancedEuler(), in_units(problem, time=1e6), STEPS)))
    assert low > 0.25
    assert high < 0.75


def test_half_powers_are_no_wrong_limit() -> None:
    """Errors of a balanced step fall with powers of the root of h, and cross 0 at short steps in slow time."""
    found = moment_orders(moment_errors(BalancedEuler(), in_units(spiral(), time=100.0), STEPS))
    assert all(order.high > 0.25 for order in found)


def test_an_order_beside_a_change_of_sign_refutes_nothing() -> None:
    """The mean error of a balanced step is a h^1.5 - b h^2, and near 0 at the shortest steps in fast time."""
    record = local_strong(BalancedEuler(), in_units(double_well(), time=1e-3))
    order = strong_orders(record)[-1]

    assert order.turns
    assert order.order < 0.2
    assert judge_strong(order, 0.5).verdict is Verdict.INCONCLUSIVE
    assert not strong_orders(local_strong(BalancedEuler(), double_well()))[-1].turns


@pytest.mark.parametrize("problem", [double_well(), gbm(), spiral()], ids=["double-well", "growth", "spiral"])
def test_an_error_in_slow_time_is_not_rounding(problem: Problem) -> None:
    """Euler's method has weak order 1 and not 2 where the horizon is 1e6 and all rates are as small."""
    slow = in_units(problem, time=1e6)

    assert weak_opinion(EulerMaruyama(), slow, 1.0).verdict is Verdict.VERIFIED
    assert weak_opinion(EulerMaruyama(), slow, 2.0).verdict is Verdict.REFUTED


def test_the_unit_of_time_is_longer_for_slow_equations_alone() -> None:
    """It is 1 on long horizons too, but where nothing happens in it: neither along solutions nor in time."""
    slow = in_units(double_well(), time=1e6)
    assert 1e4 < OneStep(EulerMaruyama(), slow).time_unit < 1e6
    assert OneStep(EulerMaruyama(), double_well(horizon=1e3)).time_unit == 1.0
    for rate, unit in ((1.0, 1.0), (1e-3, 2.0**10), (1e-6, OneStep(EulerMaruyama(), slow).time_unit)):
        forced = replace(slow, drift=lambda t, x, rate=rate: slow.drift(t, x) + 1e-6 * np.sin(rate * t))
        assert OneStep(EulerMaruyama(), forced).time_unit == pytest.approx(unit, rel=0.6)


def test_a_frame_is_centred_where_a_component_stays() -> None:
    """One near 300 that goes 2 away is measured from there, one that goes as far as it is large from 0."""
    frame = frame_of(np.array([[300.0, 301.0, 298.0], [1.0, -0.5, 0.7], [5.0, 5.0, 5.0]]))
    assert frame.centre[:, 0].tolist() == [300.0, 0.0, 0.0]
    assert frame.unit[:, 0].tolist() == [2.0, 1.0, 8.0]
    z = frame.of(np.array([[302.0], [3.0], [8.0]]))
    square, linear = np.diag([1.0, 2.0, 0.0]), np.array([-3.0, 0.5, 0.0])
    seen = frame.coefficients(linear, square) @ test_functions.values(z)
    constant = 300.0**2 - 3.0 * 300.0
    assert seen == pytest.approx([302.0**2 - 3.0 * 302.0 + 2.0 * 9.0 + 0.5 * 3.0 - constant])
