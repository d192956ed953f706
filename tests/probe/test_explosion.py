"""Moments that grow without bound as the step size falls, by a run after rare noise."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import pytest

from cells import Formula
from facade import (
    BAOAB,
    DriftTruncatedEuler,
    EulerMaruyama,
    ExplicitProjectionEuler,
    HalfExplicitEuler,
    Heun,
    Invariant,
    Milstein,
    PlatenWeak2,
    SemiImplicitProjectionEuler,
    Stability,
    StochasticTheta,
    Strong,
    TamedEuler,
    delay_test,
    double_well,
    explosion,
    gbm,
    grows_linearly,
    harmonic_langevin,
    levy_area,
    ou,
    pendulum,
    rests_on_moments,
)
from sdaeverify import SDE, Claim, DelaySDAE, Step

ONE = np.ones((1, 1, 1))


def sde(drift, start=(0.5,), diffusion=lambda x: ONE, noise_dim=1) -> SDE:
    """Return an equation that does not depend on time."""
    return SDE(
        drift=lambda t, x: drift(x),
        diffusion=lambda t, x: np.broadcast_to(diffusion(x), (len(start), noise_dim, x.shape[1])),
        start=list(start), noise_dim=noise_dim, horizon=1.0, source="test",
    )  # fmt: skip


def column(*values) -> np.ndarray:
    return np.array(values, dtype=float)[:, None, None]


CUBIC, POWER_1_5 = sde(lambda x: x - x**3), sde(lambda x: -x * np.sqrt(np.abs(x)))
SQUARED_NOISE = sde(lambda x: x - x**3, diffusion=lambda x: 0.5 * (x * x)[:, None])
ODD_UNITS = sde(lambda x: -x - 1e24 * x**3, (1e-12,), lambda x: 1e-12 * ONE)
POWER_9 = sde(lambda x: -(x**9))
DUFFING = sde(lambda x: np.stack([x[1], x[0] - x[0] ** 3 - x[1]]), (0.5, 0.0), lambda x: column(0.0, 1.0))


@pytest.mark.parametrize("problem", [CUBIC, POWER_1_5, POWER_9, SQUARED_NOISE, ODD_UNITS, DUFFING, double_well()])
@pytest.mark.parametrize("scheme", [EulerMaruyama(), Heun()])
def test_explicit_schemes_explode_where_coefficients_grow_faster_than_linearly(scheme, problem):
    """So Hutzenthaler, Jentzen & Kloeden (2011) prove, whatever the unit and whether noise is additive."""
    assert explosion(scheme, problem).explodes


@dataclass(frozen=True)
class Timed(Formula):
    """A step that depends on time."""

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return self.rule(problem, state, t, h, noise)


class Counted(NamedTuple):
    """A state with the number of its steps."""

    x: np.ndarray
    steps: np.ndarray


class Alternating(EulerMaruyama):
    """Euler's scheme in every second step, the tamed one in the others."""

    name: ClassVar[str] = "alternating"

    def enter(self, problem, state, t, h):
        return Counted(state, np.zeros((1, state.shape[1])))

    def parts(self, problem, state):
        return {"x": state.x}

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        plain = super().step(problem, state.x, t, h, noise).state
        tamed = TamedEuler().step(problem, state.x, t, h, noise).state
        return Step(Counted(np.where(state.steps % 2 == 0, plain, tamed), state.steps + 1))


@pytest.mark.parametrize("degree", [3, 5, 9])
def test_the_step_that_is_shown_is_one_of_the_scheme(degree):
    """From |x| far out a step of Euler's scheme leads to h |x|^m."""
    found = explosion(EulerMaruyama(), sde(lambda x: -(x**degree)))

    assert found.after == pytest.approx(found.h * found.before**degree, rel=0.05)


@pytest.mark.parametrize("scheme", [TamedEuler(), DriftTruncatedEuler(), StochasticTheta()])
def test_schemes_for_such_drifts_do_not_explode(scheme):
    """Tamed, truncated and implicit schemes have the moments that their papers prove."""
    for problem in (CUBIC, DUFFING, double_well()):
        assert not explosion(scheme, problem).explodes


def test_bounded_increments_never_reach_where_a_state_explodes():
    """Explicit steps with three-point increments stay near the wells; the same steps with normal ones explode."""
    normal = Formula(lambda problem, x, h, noise: PlatenWeak2().step(problem, x, 0.0, h, noise))

    assert not explosion(PlatenWeak2(), double_well()).explodes
    assert explosion(normal, double_well()).explodes


def test_taming_the_drift_does_not_tame_the_noise():
    """A diffusion of power 2 explodes with it."""
    assert explosion(TamedEuler(), SQUARED_NOISE).explodes


LINEAR = [
    gbm(),
    ou(),
    levy_area(),
    sde(lambda x: -50.0 * x, (1e14,), lambda x: 1e12 * ONE),
    sde(lambda x: -50.0 * x, (1e-14,), lambda x: 1e-12 * ONE),
    sde(lambda x: -1e6 * x),
    sde(lambda x: 20.0 * x * np.sin(x * x)),
    sde(lambda x: -x * np.log1p(x * x)),
    sde(lambda x: 1.0 - x, (1.0,), lambda x: np.sqrt(np.abs(x))[:, None]),
    sde(lambda x: -(np.maximum(x, 0.0) ** 3)),
    sde(lambda x: np.stack([0.0 * x[0], x[0] ** 3]), (0.5, 0.0), lambda x: column(1.0, 0.0)),
    sde(lambda x: np.stack([0.0 * x[0], np.exp(x[0])]), (0.5, 0.0), lambda x: column(1.0, 0.0)),
    sde(lambda x: np.stack([-x[0], -(x[1] ** 3)]), (0.5, 0.5), lambda x: column(1.0, 0.0)),
]


@pytest.mark.parametrize("problem", LINEAR)
def test_nothing_explodes_without_growth_that_is_fed_back(problem):
    """Neither do linear coefficients in any unit, nor x log x, nor growth that noise does not reach or feed back."""
    schemes = [EulerMaruyama(), Heun(), *([Milstein()] if problem.noise_dim == 1 else [])]
    for scheme in schemes:
        assert not explosion(scheme, problem).explodes


def test_velocities_on_a_circle_explode_where_the_centrifugal_term_is_explicit():
    """Omega+ = omega sqrt(1 + (h omega)^2) squares a velocity; a multiplier that is solved for keeps its size."""
    assert explosion(ExplicitProjectionEuler(), pendulum()).explodes
    assert explosion(ExplicitProjectionEuler(skip=3), pendulum()).explodes
    for scheme in (HalfExplicitEuler(), SemiImplicitProjectionEuler()):
        assert not explosion(scheme, pendulum()).explodes


def test_lagged_and_langevin_steps_of_linear_problems_do_not_explode():
    """The delay is removed, so that what is lagged is a component beside x."""
    assert isinstance(delay_test("II"), DelaySDAE)
    assert not explosion(StochasticTheta(), delay_test("II")).explodes
    assert not explosion(BAOAB(), harmonic_langevin()).explodes


def test_a_scheme_that_explodes_late_or_in_every_second_step_is_seen():
    """Runs begin early and late, and exponents are compared over three steps."""

    def late(problem, x, t, h, noise):
        return (EulerMaruyama() if t > 0.5 else TamedEuler()).step(problem, x, t, h, noise)

    assert explosion(Timed(late), CUBIC).explodes
    assert explosion(Alternating(), CUBIC).explodes


def test_steps_that_raise_far_out_show_no_growth():
    """Where nothing can be seen, nothing is said."""

    def rule(problem, x, h, noise):
        if np.abs(x).max() > 1e3:
            raise ValueError("far")
        return x + h * (x - x**3) + noise.dW

    assert not explosion(Formula(rule), CUBIC).explodes


@pytest.mark.parametrize(("problem", "linear"), [(CUBIC, False), (POWER_1_5, False), (SQUARED_NOISE, False),
    (ODD_UNITS, False), (DUFFING, False), (levy_area(), False), (pendulum().view(SDE), False),
    *((problem, True) for problem in [gbm(), ou(), *LINEAR[3:9]])])  # fmt: skip
def test_linear_growth_is_measured(problem, linear):
    """The trait is set by the form: no author states it."""
    assert grows_linearly(problem) is linear
    assert ("linear-growth" in problem.traits) is linear


@pytest.mark.parametrize("sense", ["in mean square", "in probability"])
def test_only_what_rests_on_moments_is_held_against_their_growth(sense: str) -> None:
    """An order in mean square and an invariant law do, an order in probability does not: no run is made for it."""
    expected = {Strong(): sense == "in mean square", Invariant(): True, Stability(): False}
    for measure, rests in expected.items():
        assert rests_on_moments(Claim(measure=measure.name, value=1.0, sense=sense, source="test"), measure) is rests
