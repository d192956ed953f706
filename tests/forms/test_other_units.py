"""Problems in units far from order one can be built, and their checks tell right from wrong there."""

import numpy as np
import pytest

from facade import StochasticTheta, nonlinear_constraint, pendulum_velocity_noise, why_not_algebraic
from sdaeverify import HolonomicSDAE, ProblemError
from units import delay_in_units, mechanics_in_units


def on_a_circle(size, jacobian):
    """Return free motion on a circle of some radius, its constraint without a unit."""
    return HolonomicSDAE(
        force=lambda t, r, v: 0.0 * r,
        diffusion=lambda t, r, v: size * np.eye(2)[..., None] + 0.0 * r[:, None],
        constraint=lambda r: 1.0 - np.sqrt((r**2).sum(axis=0, keepdims=True)) / size,
        jacobian=jacobian,
        position=[0.0, size],
        velocity=[size, 0.0],
        noise_dim=2,
        horizon=1.0,
        source="test",
    )


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1.0])
def test_a_right_derivative_is_taken_and_a_wrong_one_is_not(size):
    """Difference quotients over lengths of 1e-5 said nothing of a circle of radius 1e-6."""

    def right(r):
        return (-r / np.sqrt((r**2).sum(axis=0)) / size)[None]

    assert on_a_circle(size, right).constraints == 1
    assert on_a_circle(size, None).constraints == 1
    with pytest.raises(ProblemError, match="jacobian disagrees"):
        on_a_circle(size, lambda r: 1.01 * right(r))


@pytest.mark.parametrize("scale", [1.0, 1e6, 1e8])
def test_views_in_large_units_can_be_built(scale):
    """Two ways to a product that is 0 differ by rounding, which passed for a mistake of the author."""
    problem = mechanics_in_units(pendulum_velocity_noise(), scale=scale)

    assert problem.ito().dimension == 5


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_lagged_values_are_drawn_about_the_state(scale):
    """Beside x of 1e-9 a lagged value of 0.1 has no root, and steps passed for such that do not solve for y."""
    problem = delay_in_units(nonlinear_constraint(), scale=scale)

    assert why_not_algebraic(StochasticTheta(), problem) == ""
