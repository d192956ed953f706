"""Whether one step follows the equation: the one comparison that all probes of one step ask."""

from dataclasses import replace

import numpy as np
import pytest

from conformance.test_run_memory import Unentered
from facade import (
    EulerMaruyama,
    HalfExplicitEuler,
    KeptAlgebraic,
    ProjectedEuler,
    circle,
    consistency,
    consistency_at,
    consistency_opinions,
    double_well,
    gbm,
    gbm_algebraic,
    judge_departure,
    law_departure,
    local_strong,
    noncommuting,
    ou,
    pendulum,
    probe_consistency,
    strong_orders,
)
from probe import strong_cells as s
from sdaeverify.measuring import Evidence, Kind, Verdict
from sdaeverify.probing import OneStep

REFUTED, VERIFIED = Verdict.REFUTED, Verdict.VERIFIED
MECHANICS = ("r", "v", "mu")


def off(drift=0.0, power=0.0, strength=1.0):
    """Return Euler-Maruyama with a drift too much by a multiple of h^power, and a factor at the noise."""
    return s.Formula(lambda p, x, h, n: s.euler(p, x, h, n, drift=1.0 + drift * h**power, strength=strength))


def other_noise(problem, x, h, noise):
    """Return Euler-Maruyama with the two motions swapped, which has the law of the equation if B does not change."""
    return s.euler(problem, x, h, noise._replace(dW=-noise.dW))


def departure(scheme, problem, component=None):
    """Return the deviation of a component of the scheme's form, or of its full state."""
    view = problem.view(scheme.form)
    record = consistency(scheme, view)
    return record.departure(tuple(view.equation().names or "x"), component)


@pytest.mark.parametrize(
    ("scheme", "problem"),
    [
        (EulerMaruyama(), gbm()),
        (EulerMaruyama(), noncommuting()),
        (HalfExplicitEuler("none"), pendulum()),
        (ProjectedEuler(), circle()),
    ],
    ids=lambda value: getattr(value, "label", ""),
)
def test_right_schemes_follow_the_equation(scheme, problem):
    """No right scheme deviates from the equation, whatever its order."""
    assert departure(scheme, problem) == ""


@pytest.mark.parametrize(
    ("wrong", "moment"),
    [
        ({"drift": 0.01}, "the mean"),
        ({"drift": -0.02}, "the mean"),
        ({"strength": 1.005}, "the covariance"),
        ({"strength": 0.5}, "the covariance"),
        ({"strength": -1.0}, "the covariance with the noise"),
    ],
)
@pytest.mark.parametrize("problem", [gbm, ou])
def test_a_wrong_coefficient_is_a_deviation(wrong, moment, problem):
    """A hundredth of the drift or of the noise's variance is enough, and noise of the wrong sign.

    Points at which the drift is below a hundredth of the motion do not show an error of a hundredth of it.
    """
    found = departure(off(**wrong), problem())

    assert found.startswith(f"{moment} of one step is off by")
    assert int(found.partition(" at any h, at ")[2].partition(" of 512 points")[0]) > 500


def test_noise_of_the_wrong_sign_has_the_right_law():
    """The wrong twin of a claim along paths: claims in law alone ask for the first two moments."""
    wrong = s.Formula(other_noise)

    assert departure(wrong, ou()).startswith("the covariance with the noise of one step is off by")
    assert law_departure(wrong, ou()) == ""


@pytest.mark.parametrize("power", [0.3, 0.5, 1.0])
def test_a_drift_that_is_right_in_the_limit_is_none(power):
    """What vanishes with a power of h is consistent, however slowly."""
    assert departure(off(drift=3.0, power=power), ou()) == ""


def test_a_pure_output_deviates_by_itself():
    """A wrong multiplier spoils itself and the full state, not the positions that do not depend on it."""

    def opposite(problem, old, h, noise, new):
        return new._replace(mu=2.0 * old.mu - new.mu)

    wrong = s.Altered(HalfExplicitEuler("none"), opposite)
    found = [departure(wrong, pendulum(), component) for component in (0, 1, 2, None)]

    assert [bool(each) for each in found] == [False, False, True, True]
    assert "of the motion of mu at any h" in found[2]
    assert law_departure(wrong, pendulum()) == ""


def test_a_wrong_velocity_spoils_what_it_affects():
    """A velocity with too much noise has a wrong position, too, and the multipliers are integrated along both."""
    wrong = s.Altered(HalfExplicitEuler("none"), s.velocity_noise)

    assert all("of the motion of v at any h" in departure(wrong, pendulum(), index) for index in range(3))


def test_a_deviation_refutes():
    """And nothing else does."""
    assert judge_departure("").verdict is VERIFIED
    assert judge_departure("off").verdict is REFUTED
    assert judge_departure("off").reason.has(Kind.INCONSISTENT)


def test_a_solver_that_stops_early_does_not_hide_a_wrong_equation():
    """Where its errors outgrow those of the equation at short steps, longer ones show the wrong limit."""

    def stopped(problem, x, h, noise, rule):
        exact = rule(problem, x, h, noise)
        return exact + 1e-6 * np.sin(1e5 * exact)

    right, wrong = (
        s.Formula(lambda p, x, h, n, rule=rule: stopped(p, x, h, n, rule)) for rule in (s.euler, s.no_correction)
    )

    assert departure(right, gbm()) == ""
    assert departure(wrong, gbm()).startswith("the mean of one step is off by")


def test_a_step_that_is_wrong_below_a_small_size_deviates():
    """No solver stops at a ten-thousandth of the motion: the drift of half the state below h = 1e-4."""

    def rule(problem, x, h, noise):
        return s.euler(problem, x, h, noise) - (0.5 * h * problem.drift(0.0, x) if h < 1e-4 else 0.0)

    assert departure(s.Formula(rule), gbm()).startswith("the mean of one step is off by")


def test_orders_of_the_scheme_alone_do_not_show_a_wrong_limit():
    """A scheme that solves another equation has the orders of the right one: the comparison is needed."""
    right, wrong = (strong_orders(local_strong(scheme, gbm()))[-1].order for scheme in (EulerMaruyama(), off(0.5)))

    assert np.isclose(right, wrong, atol=0.01)
    assert departure(off(0.5), gbm())


def test_a_step_whose_memory_is_unknown_is_not_compared():
    """Memory that `enter` does not set is that of no step from a given state."""
    assert consistency(Unentered(), double_well()) is None


def test_opinions_are_those_of_what_was_probed():
    """Of each component and of the state; without a probe, or where a step keeps its y, there are none."""

    def opinions(scheme, problem):
        probed = replace(Evidence.of_one_step(scheme, problem), tally=probe_consistency(scheme, problem))
        return {name: opinion.verdict for name, opinion in consistency_opinions(probed).items()}

    assert opinions(EulerMaruyama(), gbm()) == {"x": VERIFIED, "state": VERIFIED}
    assert opinions(off(0.5), gbm()) == {"x": REFUTED, "state": REFUTED}
    assert opinions(KeptAlgebraic(), gbm_algebraic()) == {}
    assert consistency_opinions(Evidence.of_one_step(EulerMaruyama(), gbm())) == {}


def test_steps_are_compared_at_given_states():
    """At each of them that is finite and moves; where none is left, nothing is known."""
    states = np.array([[1.0, 2.0, np.nan]])
    right, wrong = (consistency_at(OneStep(scheme, gbm()), states) for scheme in (EulerMaruyama(), off(0.5)))

    assert (right.points, right.at[0], right.departure(["x"])) == (2.0, 0.0, "")
    assert (wrong.points, wrong.at[0]) == (2.0, 2.0)
    assert "at 2 of 2 points" in wrong.departure(["x"])
    assert consistency_at(OneStep(EulerMaruyama(), gbm()), np.zeros((1, 1))) is None


def test_points_without_a_deviation_are_not_counted():
    """A drift that is wrong beyond a state deviates there alone."""

    def rule(problem, x, h, noise):
        return s.euler(problem, x, h, noise) + 0.5 * h * (x > 1.5)

    found = consistency_at(OneStep(s.Formula(rule), gbm()), np.array([[0.5, 1.0, 2.0]]))

    assert (found.points, found.at[0]) == (3.0, 1.0)
