"""Weak orders above 1 where lagged values lie between mesh points."""

from dataclasses import dataclass

import numpy as np
import pytest

import sdaeverify
from facade import StochasticTheta, delay_ou
from sdaeverify import Claim, DelaySDAE
from sdaeverify.measuring import Order

SECOND = Claim(measure="weak", value=2.0, source="planted: right on the points of a mesh")
WHOLE, BETWEEN = 0.25, 0.37


@dataclass(frozen=True)
class SecondOrder(StochasticTheta):
    """The trapezoidal rule, of which weak order 2 is claimed for delays as well."""

    name = "second-order"

    @property
    def promises(self):
        """The claim alone."""
        return (SECOND,)


def squared(delay: float) -> DelaySDAE:
    """Return dx = (-x + v^2) dt + 0.7 dW: between mesh points the mean of v^2 lacks 0.49 delta (1 - delta) h."""
    return DelaySDAE(
        drift=lambda t, x, v, y: -x + v**2,
        diffusion=lambda t, x, v, y: np.full((1, 1, 1), 0.7),
        delay=delay,
        history=lambda t: [0.5],
        horizon=1.0,
        noise_dim=1,
        traits=frozenset({"additive-noise"}),
        observables={"x": lambda t, s: s["x"][0]},
        source="made up",
    )


def on_mesh() -> DelaySDAE:
    """Return it with a delay of whole steps."""
    return squared(WHOLE)


def between() -> DelaySDAE:
    """Return it with a delay that is no multiple of any step."""
    return squared(BETWEEN)


def linear_between() -> DelaySDAE:
    """Return a linear equation with such a delay."""
    return delay_ou(tau=BETWEEN, horizon=1.0)


def verdicts(problem) -> set[str]:
    """Return the verdicts on the mean of x."""
    rows = sdaeverify.verify([SecondOrder()], [problem], measures=["weak"], paths=256).verdicts
    return set(rows.verdict[rows.quantity == "x"])


def test_order_two_is_verified_where_lagged_values_are_whole_steps_behind():
    """One step, which has the older solution at its ends, stands for all steps then."""
    assert verdicts(on_mesh) == {"verified"}


@pytest.mark.long
@pytest.mark.parametrize("problem", [between, linear_between])
def test_one_step_does_not_verify_order_two_between_mesh_points(problem):
    """The order is 1 where the drift is not linear in the lagged value, which one step does not tell from others."""
    assert verdicts(problem) == {"inconclusive"}


def test_the_shipped_rule_claims_it_without_delay_alone():
    """Whether a delay lies on the mesh is no trait of a problem."""
    (second,) = (claim for claim in StochasticTheta().promises if claim.value == Order(2.0))

    assert "no-delay" in second.when
