"""Whether one step follows the equation: told at fixed states, without sampling."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

from facade import EulerMaruyama, HalfExplicitEuler, Milstein, ProjectedEuler, circle, consistency, gbm, ou, pendulum
from sdaeverify import SDE, HolonomicState, Scheme, Step
from sdaeverify.measures.path_errors.consistency import judge_consistency
from sdaeverify.measuring import Kind, Verdict
from sdaeverify.numerics import apply

REFUTED, VERIFIED = Verdict.REFUTED, Verdict.VERIFIED


@dataclass(frozen=True)
class OffEuler(Scheme):
    """Euler-Maruyama with a drift too much by a multiple of h^power, and a factor at the noise."""

    drift: float = 0.0
    power: float = 0.0
    noise_factor: float = 1.0

    name: ClassVar[str] = "off-euler"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, state, t, h, noise):
        drift = (1.0 + self.drift * h**self.power) * problem.drift(t, state)
        return Step(state + h * drift + self.noise_factor * apply(problem.diffusion(t, state), noise.dW))


@dataclass(frozen=True)
class OldTangent(HalfExplicitEuler):
    """The half-explicit scheme whose velocity lies in the tangent space of the point before."""

    truncation: str | float = "none"

    def step(self, problem, state, t, h, noise):
        new = super().step(problem, state, t, h, noise).state
        normal = state.r
        v = new.v - normal * (normal * new.v).sum(axis=0)
        return Step(HolonomicState(new.r, v, new.mu))


@pytest.mark.parametrize(
    ("scheme", "problem"),
    [
        (EulerMaruyama(), gbm()),
        (Milstein(), gbm()),
        (EulerMaruyama(), pendulum()),
        (HalfExplicitEuler(), pendulum()),
        (HalfExplicitEuler("none"), pendulum()),
        (ProjectedEuler(), circle()),
    ],
    ids=lambda value: getattr(value, "label", ""),
)
def test_right_schemes_follow_the_equation(scheme, problem):
    """Whatever the order, no right scheme is told to leave the equation."""
    assert judge_consistency(consistency(scheme, problem.view(scheme.form))).verdict is VERIFIED


@pytest.mark.parametrize("wrong", [{"drift": 0.01}, {"drift": -0.02}, {"noise_factor": 1.005}, {"noise_factor": 0.5}])
@pytest.mark.parametrize("problem", [gbm, ou])
def test_a_wrong_coefficient_is_refuted(wrong, problem):
    """A hundredth of the drift or of the noise's variance is enough."""
    opinion = judge_consistency(consistency(OffEuler(**wrong), problem()))

    assert opinion.verdict is REFUTED
    assert opinion.reason.has(Kind.INCONSISTENT)
    assert "100% of the states" in str(opinion.reason)


@pytest.mark.parametrize("power", [0.3, 0.5, 1.0])
def test_a_drift_that_is_right_in_the_limit_is_not_refuted(power):
    """What vanishes with a power of h is consistent, however slowly."""
    assert judge_consistency(consistency(OffEuler(drift=3.0, power=power), ou())).verdict is VERIFIED


def test_what_later_steps_take_back_is_left_open():
    """A velocity that lags behind by one tangent space is wrong in the first step, and converges all the same."""
    opinion = judge_consistency(consistency(OldTangent(), pendulum()), component=1)

    assert opinion.verdict is Verdict.INCONCLUSIVE
    assert "later ones at 0%" in str(opinion.reason)


def test_a_pure_output_is_asked_about_by_itself():
    """A wrong multiplier spoils itself and the full state, not the positions that do not depend on it."""

    @dataclass(frozen=True)
    class Opposite(HalfExplicitEuler):
        def step(self, problem, state, t, h, noise):
            new = super().step(problem, state, t, h, noise).state
            return Step(new._replace(mu=2.0 * state.mu - new.mu))

    record = consistency(Opposite("none"), pendulum())

    assert [judge_consistency(record, i).verdict for i in range(3)] == [VERIFIED, VERIFIED, REFUTED]
    assert judge_consistency(record).verdict is REFUTED
