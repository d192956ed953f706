"""Orders of what the memory of a run changes, and the claims that single steps decide up to them."""

from math import inf

import numpy as np
import pytest

from averaged_noise import LeimkuhlerMatthews
from conformance.test_run_memory import Tired
from facade import (
    ExplicitProjectionEuler,
    OrderReport,
    StochasticTheta,
    double_well,
    gbm,
    gbm_algebraic,
    ou,
    pendulum,
)
from planted import memory_schemes as m
from sdaeverify import Scheme
from sdaeverify.contracts.finding import Verdict
from sdaeverify.probe.step.memory import memory_orders
from sdaeverify.probing import OneStep, moment_errors, why_not_moments
from sdaeverify.verdicts.opinions import local_opinion, of_memory

# Measured orders of both schemes and their theory: sizes are known to 5 per cent, and few of them are asymptotic.
OFF = 0.15
FIRST = {
    "renewed every second step": m.EverySoMany(),
    "renewed every fifth step": m.EverySoMany(period=5),
    "from a time on": m.SetsIn(time=0.6),
    "a running mean": m.RunningMean(),
    "old noise": m.OldNoise(),
    "two drifts": m.AdamsBashforth(),
}
LOWER = {
    "h^(-1/3)": m.EverySoMany(power=1 / 3),
    "h^(-1/4)": m.EverySoMany(power=0.25),
    "h^(-1/5)": m.EverySoMany(power=0.2),
}


@pytest.mark.parametrize(
    "name",
    ["a running mean", *(pytest.param(name, marks=pytest.mark.long) for name in FIRST if name != "a running mean")],
)
def test_memory_of_a_fixed_number_of_steps_has_the_order_1(name: str) -> None:
    """With additive noise, a drift of a few steps ago changes runs by O(h), in the mean as well."""
    found = memory_orders(OneStep(FIRST[name], double_well()))
    assert found.vanish
    assert found.strong[0] == pytest.approx(1.0, abs=OFF)
    assert float(found.weak) == pytest.approx(1.0, abs=OFF)


@pytest.mark.parametrize(
    "name", ["h^(-1/5)", *(pytest.param(name, marks=pytest.mark.long) for name in LOWER if name != "h^(-1/5)")]
)
def test_memory_that_lasts_longer_has_a_lower_order(name: str) -> None:
    """Of h^(-1/5) steps and more: an order of 0.8 or less, told from 1 by the accuracy of strong orders."""
    assert memory_orders(OneStep(LOWER[name], double_well())).strong[0] < 0.9


def test_memory_that_changes_nothing_has_no_order() -> None:
    """A counter without effect, a projection in each step, an algebraic component that each step solves for."""
    for scheme, problem in (
        (Tired(10**6), gbm()),
        (ExplicitProjectionEuler(), pendulum()),
        (StochasticTheta(), gbm_algebraic()),
    ):
        found = memory_orders(OneStep(scheme, problem))
        assert np.all(found.strong == inf)
        assert found.weak == inf


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", [LeimkuhlerMatthews(), m.SetsIn(steps=300)], ids=["half an increment", "late"])
def test_memory_that_does_not_vanish_leaves_all_to_paths(scheme: Scheme) -> None:
    """A step that begins with half of the noise, and a change after 300 steps, which no coarse run makes."""
    assert not memory_orders(OneStep(scheme, double_well())).vanish
    assert "steps of a run differ" in OneStep(scheme, double_well()).why_not_probed()


def test_single_steps_decide_up_to_the_order_of_memory() -> None:
    """Above it they verify nothing, and refute nothing that is not surely below it."""
    verified, refuted = (local_opinion(verdict, "found") for verdict in (Verdict.VERIFIED, Verdict.REFUTED))
    assert of_memory(verified, 0.9, 1.0, 2.0).verdict is Verdict.VERIFIED
    assert of_memory(verified, 1.75, 1.0, 2.0).verdict is Verdict.INCONCLUSIVE
    assert of_memory(refuted, 1.75, 1.0, 0.5).verdict is Verdict.REFUTED
    assert of_memory(refuted, 1.75, 1.0, 1.0).verdict is Verdict.INCONCLUSIVE


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("scheme", [m.EverySoMany(), m.EverySoMany(period=7), m.SetsIn(time=0.6), m.RunningMean()])
def test_no_class_is_verified_above_the_order_of_memory(scheme: Scheme) -> None:
    """Weak order 2 of Heun's method is that of its step without a history."""
    rows = {row.measure: row for row in OrderReport.of(scheme, classes="additive", motions=1).rows}
    assert rows["weak"].verdict is Verdict.INCONCLUSIVE
    assert "memory adds errors" in rows["weak"].why


@pytest.mark.long
def test_langevin_dynamics_with_an_old_force_is_not_verified() -> None:
    """The same of a class that a form poses."""
    rows = {row.measure: row for row in OrderReport.of(m.OldForce(), classes="langevin", motions=1).rows}
    assert rows["weak"].verdict is Verdict.INCONCLUSIVE
    assert rows["strong"].verdict is Verdict.VERIFIED


@pytest.mark.long
def test_a_right_method_of_two_steps_is_verified_for_its_class() -> None:
    """Its older drift changes runs by no more than its order allows."""
    rows = OrderReport.of(m.AdamsBashforth(), classes="additive", motions=1).rows
    assert [row.verdict for row in rows if row.claim == row.claim] == [Verdict.VERIFIED] * 2


@pytest.mark.long
def test_moments_are_of_steps_that_memory_does_not_change_later() -> None:
    """A linear step that remembers, and does so from some time or number of steps on, has no moment equations."""
    for scheme, linear in ((m.SetsIn(steps=100), False), (m.SetsIn(time=0.6), False), (LeimkuhlerMatthews(), True)):
        assert why_not_moments(scheme, ou()) == ""
        assert moment_errors(scheme, ou(), [8, 16, 32, 64]).linear is linear
