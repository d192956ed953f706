"""What of a linear system matters for stability: observed memory, and states that keep the constraints."""

import numpy as np
import pytest

from facade import (
    HalfExplicitEuler,
    Operator,
    StochasticTheta,
    spectral_radius,
    step_moments,
    why_not_stability,
)
from facade import stability_stability as stability
from probe import linear_cells as c
from sdaeverify import DelaySDAE, HolonomicSDAE, HolonomicState, Increment, Scheme, Step
from sdaeverify.probe.linear.linear_map import MemoryStep
from sdaeverify.probe.linear.observable_part import essential_equation, essential_operator, restrict_to_observed
from sdaeverify.probing import OneStep, linear_equation


def on_a_line() -> HolonomicSDAE:
    """Return a damped oscillator with noise in its velocity, kept on the line r_2 = r_1/2."""
    return HolonomicSDAE(
        constraint=lambda r: r[1:2] - 0.5 * r[0:1],
        force=lambda t, r, v: -2.0 * r - 3.0 * v,
        diffusion=lambda t, r, v: (0.5 * v)[:, None],
        position=[1.0, 0.5],
        velocity=[0.0, 0.0],
        horizon=1.0,
        noise_dim=1,
        source="test",
    )


# The same as a free system of the coordinate along the line and its velocity.
FREE = c.linear([[0.0, 1.0], [-2.0, -3.0]], [[[0.0, 0.0], [0.0, 0.5]]])


def test_memory_that_nothing_depends_on_is_left_out() -> None:
    """Of the two-step scheme, the state and the last drift stay; the walk beside them goes."""
    step = MemoryStep(OneStep(c.AdamsBashforth(), c.linear(-2.0, [0.5])), 0.1)
    operator = step_moments(step.one_step, 0.1).operator
    found, rows = restrict_to_observed(step, operator)
    assert rows.shape == (3, 4)
    assert np.abs(rows[:2, 2]).max() == 0.0
    assert spectral_radius(operator.homogeneous).rho == pytest.approx(4.0, rel=1e-12)
    assert spectral_radius(found.homogeneous).rho < 1.0


def test_memory_that_comes_back_late_is_kept() -> None:
    """The oldest of six past states acts on the components after six steps."""
    step = MemoryStep(OneStep(c.Delayed(6, -0.5), c.linear(-2.0, [0.5])), 0.1)
    assert len(restrict_to_observed(step, step_moments(step.one_step, 0.1).operator)[1]) == 8


def test_small_contributions_of_many_maps_make_no_rows_beyond_the_dimension() -> None:
    """Maps that differ by a part in 10^12 to 10^9 of their size, where one projection leaves rounding."""
    rng = np.random.default_rng(5)
    step = MemoryStep(OneStep(c.Delayed(6, -0.5), c.linear(-2.0, [0.5])), 0.1)
    for size in (1e-12, 1e-11, 1e-10, 1e-9):
        common, k = rng.standard_normal((1 + step.dimension, 2)), step.dimension + 1
        low = (common @ rng.standard_normal((2, k)))[..., None]
        factors = low + size * rng.standard_normal((k, k, 5))
        rows = restrict_to_observed(step, Operator(factors, np.full(5, 0.2)))[1]
        assert rows @ rows.T == pytest.approx(np.eye(len(rows)), abs=1e-12)


def test_a_constrained_problem_decays_like_its_free_form() -> None:
    """Positions off the line and the sum of multipliers would not decay."""
    found = essential_equation(OneStep(HalfExplicitEuler(), on_a_line()))
    assert found.abscissa == pytest.approx(linear_equation(FREE).homogeneous.abscissa, rel=1e-12)
    assert found.decays() is True
    assert linear_equation(on_a_line().ito()).homogeneous.decays() is not True


def test_a_constrained_scheme_is_stable_like_the_same_scheme_on_the_free_form() -> None:
    """The half-explicit scheme without truncation is Euler's on the coordinate along the line."""
    problem, scheme = on_a_line(), HalfExplicitEuler(truncation="none")
    assert why_not_stability(scheme, problem) == ""
    record, free = stability(scheme, problem, [0.125]), stability(c.Formula(c.euler), FREE, [0.125])
    assert record.run.rho == pytest.approx(free.run.rho, rel=1e-12)
    assert record.boundaries == pytest.approx(free.boundaries, rel=1e-10)
    assert record.decays == 1.0


class Leaving(Scheme):
    """A scheme that leaves the line by a multiple of the position, and grows there."""

    name = "leaving"
    form = HolonomicSDAE

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        off = state.r[1:2] - 0.5 * state.r[:1]
        r = 0.5 * state.r + np.concatenate([np.zeros_like(off), 0.1 * state.r[:1] + 1.5 * off])
        return Step(HolonomicState(r, 0.5 * state.v, state.mu))


def test_states_that_a_scheme_reaches_beside_the_manifold_count() -> None:
    """Growth off the line is seen if the scheme goes there by itself."""
    one_step = OneStep(Leaving(), on_a_line())
    step = MemoryStep(one_step, 0.1)
    rho = spectral_radius(essential_operator(step, step_moments(one_step, 0.1).operator)).rho
    assert rho == pytest.approx(4.0, rel=1e-10)


@pytest.mark.long
@pytest.mark.parametrize("force", [0.0, 1.0])
def test_without_a_linear_part_second_moments_stay(force: float) -> None:
    """Of dx = force dt + 0.3 dW, 0 = y - x nothing depends on the state: it was an error, and rho is 1."""
    problem = DelaySDAE(
        drift=lambda t, x, v, y: force + 0.0 * x,
        diffusion=lambda t, x, v, y: 0.3 + 0.0 * x[:, None],
        constraint=lambda t, x, v, y: y - x,
        algebraic=1,
        delay=0.0,
        history=lambda t: [1.0],
        noise_dim=1,
        horizon=1.0,
        source="test",
    )
    record = stability(StochasticTheta(), problem, [0.1])
    assert np.isnan(record.decays)
    assert record.run.rho == pytest.approx([1.0], abs=1e-12)
    assert not record.run.sign.any()
