"""Whether a short step follows the equation at every state that solutions reach."""

from typing import ClassVar

import numpy as np
import pytest

from facade import (
    DisplacedEuler,
    angle_pendulum,
    departure,
    double_well,
    fibre_clamped,
    hyperbolic_pair,
    load_registry,
    match,
    pendulum_velocity_noise,
    select_schemes,
    violation,
)
from sdaeverify import SDE, Array, Claim, Increment, Langevin, Scheme, Step
from sdaeverify_problems.hyperbolic import hyperbolic

pytestmark = pytest.mark.long


class SameNoiseTwice(Scheme):
    """OBABO whose two Ornstein-Uhlenbeck half steps take the same normal variable."""

    name: ClassVar[str] = "same-noise-twice"
    form: ClassVar[type] = Langevin
    claims: ClassVar = (Claim(measure="weak", value=1.0, source="made up"),)

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        n, c = problem.noise_dim, np.exp(-0.5 * problem.friction * h)
        kick = problem.strength * np.sqrt((1.0 - c**2) / (2.0 * problem.friction * h)) * noise.dW
        p = c * state[n:] + kick + 0.5 * h * problem.force(state[:n])
        q = state[:n] + h * p
        return Step(np.concatenate([q, c * (p + 0.5 * h * problem.force(q)) + kick]))


def test_wrong_covariance_is_told() -> None:
    """One normal variable in the place of two independent ones gives more than the variance of both."""
    assert "the covariance of one step" in departure(SameNoiseTwice(), angle_pendulum())


def test_scheme_without_claims_is_not_held_to_the_equation() -> None:
    """A negative control departs from the equation, and breaks no promise by that."""
    assert departure(DisplacedEuler(), double_well())
    assert not violation(DisplacedEuler(), double_well())


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(
    "problem",
    [
        # Drifts of 1e5 are tamed to a fifth by the longer of these steps.
        hyperbolic(a=1.55, b=1.28, x_0=2.11, horizon=4.22),
        hyperbolic_pair(c=3.75, b_1=0.122, b_2=1.87, x_1=1.6, horizon=1.96),
        hyperbolic_pair(c=4.74, b_1=0.121, b_2=0.89, x_1=2.37, horizon=2.37),
        # Velocities of 1e-8 have multipliers of 1e-16, an output.
        pendulum_velocity_noise(sigma=3.69, theta_0=0.121, omega_0=0.234, horizon=0.736),
        # A truncation that sees a drift of 1e4.
        fibre_clamped(alpha=0.939, beta=0.493, Dr=0.0625, N=2, horizon=0.00428),
    ],
    ids=["hyperbolic", "hyperbolic-pair", "steep pair", "pendulum", "fibre"],
)
def test_shipped_schemes_follow_equations_far_out(problem: SDE) -> None:
    """Errors that vanish as steps are shortened are none, however large they are at first."""
    schemes = select_schemes(load_registry(), ["*"])
    views = [(scheme, match(scheme, problem).problem) for scheme in schemes if scheme.claims]
    with np.errstate(all="ignore"):
        assert not [departure(scheme, view) for scheme, view in views if view is not None and departure(scheme, view)]
