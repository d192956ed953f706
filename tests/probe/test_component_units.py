"""Components that are far smaller than the state have units of their own, unless they are made of its rounding."""

import numpy as np
import pytest

from facade import BAOAB, EulerMaruyama, component_units, harmonic_langevin, pendulum
from sdaeverify import SDE
from sdaeverify.probing import OneStep, cloud
from units import langevin_in_units


def units_of(scheme, problem, h):
    step = OneStep(scheme, problem)
    return component_units(step, cloud(problem, step.equation), h)


def pair(drift):
    """Return an equation of x_1 = 1e8 and of x_2 near 1."""
    return SDE(
        drift=lambda t, x: np.stack([0.0 * x[0], drift(x)]),
        diffusion=lambda t, x: np.stack([0.0 * x[:1], 0.1 + 0.0 * x[:1]]),
        start=[1e8, 1.0],
        noise_dim=1,
        horizon=1.0,
        names={"large": slice(0, 1), "small": slice(1, 2)},
        source="test",
    )


def test_components_of_one_size_have_the_unit_one():
    """Positions, velocities and a multiplier of order one are compared with the largest of them."""
    assert (units_of(EulerMaruyama(), pendulum().ito(), 0.1) == 1.0).all()


def test_a_velocity_beside_a_large_position_has_its_own_unit():
    """In units of 1e8 of length and 1e7 of time, a momentum of 10 stands beside a position of 1e8."""
    problem = langevin_in_units(harmonic_langevin(), scale=1e8, time=1e7)
    large, small = units_of(BAOAB(), problem, 1e5)

    assert large == 1.0
    assert 1e-8 < small < 1e-6


@pytest.mark.parametrize(("drift", "rounded"), [(lambda x: -x[1], False), (lambda x: x[0] - 1e8 - x[1], True)])
def test_a_component_that_is_a_difference_of_large_ones_has_their_rounding(drift, rounded):
    """A step rounds it as it does the large ones, and no error of that size is one of the scheme."""
    _, small = units_of(EulerMaruyama(), pair(drift), 0.25)

    assert bool(small > 0.01) is rounded


def test_a_component_that_is_rounding_has_no_unit_of_its_own():
    """What is 1e-16 of the state is 0 up to rounding."""
    problem = pair(lambda x: -x[1])
    x = np.array([[1e8, 1e8], [1e-9, -1e-9]])

    assert (component_units(OneStep(EulerMaruyama(), problem), x, 1e-20) == 1.0).all()
