"""Whether one step follows the equation: told at fixed states, without sampling."""

import pytest

from facade import EulerMaruyama, HalfExplicitEuler, ProjectedEuler, circle, consistency, gbm, ou, pendulum
from probe import strong_cells as s
from sdaeverify.measures.path_errors.consistency import judge_consistency
from sdaeverify.measuring import Kind, Verdict

REFUTED, VERIFIED = Verdict.REFUTED, Verdict.VERIFIED


def off(drift=0.0, power=0.0, strength=1.0):
    """Return Euler-Maruyama with a drift too much by a multiple of h^power, and a factor at the noise."""
    return s.Formula(lambda p, x, h, n: s.euler(p, x, h, n, drift=1.0 + drift * h**power, strength=strength))


def old_tangent(problem, old, h, noise, new):
    """Project the velocity onto the tangent space of the point before."""
    return new._replace(v=new.v - old.r * (old.r * new.v).sum(axis=0))


@pytest.mark.parametrize(
    ("scheme", "problem"),
    [
        (EulerMaruyama(), gbm()),
        (HalfExplicitEuler("none"), pendulum()),
        (ProjectedEuler(), circle()),
    ],
    ids=lambda value: getattr(value, "label", ""),
)
def test_right_schemes_follow_the_equation(scheme, problem):
    """Whatever the order, no right scheme is told to leave the equation."""
    assert judge_consistency(consistency(scheme, problem.view(scheme.form))).verdict is VERIFIED


@pytest.mark.parametrize("wrong", [{"drift": 0.01}, {"drift": -0.02}, {"strength": 1.005}, {"strength": 0.5}])
@pytest.mark.parametrize("problem", [gbm, ou])
def test_a_wrong_coefficient_is_refuted(wrong, problem):
    """A hundredth of the drift or of the noise's variance is enough."""
    opinion = judge_consistency(consistency(off(**wrong), problem()))

    assert opinion.verdict is REFUTED
    assert opinion.reason.has(Kind.INCONSISTENT)
    assert "100% of the states" in str(opinion.reason)


@pytest.mark.parametrize("power", [0.3, 0.5, 1.0])
def test_a_drift_that_is_right_in_the_limit_is_not_refuted(power):
    """What vanishes with a power of h is consistent, however slowly."""
    assert judge_consistency(consistency(off(drift=3.0, power=power), ou())).verdict is VERIFIED


def test_what_later_steps_take_back_is_left_open():
    """A velocity that lags behind by one tangent space is wrong in the first step, and converges all the same."""
    opinion = judge_consistency(
        consistency(s.Altered(HalfExplicitEuler("none"), old_tangent), pendulum()), component=1
    )

    assert opinion.verdict is Verdict.INCONCLUSIVE
    assert "a later one at 0%" in str(opinion.reason)


def test_a_pure_output_is_asked_about_by_itself():
    """A wrong multiplier spoils itself and the full state, not the positions that do not depend on it."""

    def opposite(problem, old, h, noise, new):
        return new._replace(mu=2.0 * old.mu - new.mu)

    record = consistency(s.Altered(HalfExplicitEuler("none"), opposite), pendulum())

    assert [judge_consistency(record, i).verdict for i in range(3)] == [VERIFIED, VERIFIED, REFUTED]
    assert judge_consistency(record).verdict is REFUTED
