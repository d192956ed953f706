"""An y with an interpolated past is judged by its own errors: with additive noise x is of order 1, y of order 1/2."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import StochasticTheta, Strong
from sdaeverify import Claim, DelaySDAE, Problem, Settings
from sdaeverify.measuring import Evidence, Tally, Verdict
from sdaeverify.probe.local.algebraic_defects import algebraic_defects, algebraic_order

SETTINGS = Settings(coarsest=8, levels=5)
TIMES = {"between mesh points": 0.3, "at mesh points": 0.25}


@dataclass(frozen=True)
class FirstOrder(StochasticTheta):
    """The explicit method with order 1 claimed of x and of y."""

    theta: float = 0.0

    name: ClassVar[str] = "first-order"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.0, source="planted"),)


def delayed(tau: float, weight: float = 1.0, sigma: float = 0.7) -> DelaySDAE:
    """Return dx = (v - x - y) dt + sigma dW, y = x/2 + weight v."""
    return DelaySDAE(
        drift=lambda t, x, v, y: v - x - y,
        diffusion=lambda t, x, v, y: np.full((1, 1, 1), sigma),
        constraint=lambda t, x, v, y: 0.5 * x + weight * v - y,
        delay=tau,
        history=lambda t: [1.0 + t],
        algebraic=1,
        noise_dim=1,
        horizon=1.0,
        traits=frozenset({"additive-noise"}),
        source="Ornstein-Uhlenbeck with a delayed force",
    )


@pytest.mark.parametrize(
    ("delta", "weight", "sigma", "order"),
    [
        (0.4, 1.0, 0.7, 0.5),
        (0.9, 1.0, 0.7, 0.5),
        (0.0, 1.0, 0.7, np.inf),
        (0.4, 0.0, 0.7, np.inf),
        (0.4, 1.0, 0.0, np.inf),
    ],
    ids=["between", "near the end", "constrained mesh", "no v in y", "no noise"],
)
def test_the_order_of_an_interpolated_past(delta: float, weight: float, sigma: float, order: float) -> None:
    """A Brownian bridge is of order 1/2; what does not reach y, or is not there, has none."""
    record = algebraic_defects(FirstOrder(), delayed(0.3, weight, sigma), delta)

    assert algebraic_order(record) == pytest.approx(order, abs=0.01)


def test_the_size_of_an_interpolated_past() -> None:
    """The defect has the variance sigma^2 h delta (1 - delta) of the bridge."""
    record = algebraic_defects(FirstOrder(), delayed(0.3), 0.4)

    np.testing.assert_allclose(record.rms, np.tile(0.7 * np.sqrt(record.h * 0.24), (13, 1)), rtol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("mesh", TIMES)
def test_a_claim_about_y_is_judged_by_the_errors_of_y(mesh: str) -> None:
    """Order 1 is refuted for y and for the full state where the delay lies between mesh points, and not for x."""
    problem, measure, scheme = delayed(TIMES[mesh]), Strong(), FirstOrder()
    zeros = np.zeros(SETTINGS.levels)
    health = Tally(sums={"failed": zeros, "lost": zeros, "truncated": zeros, "steps": zeros + 1e6})
    evidence = Evidence(scheme, problem, problem, SETTINGS, measure.probe(scheme, problem, SETTINGS), health)
    found = {each.quantity: each for each in measure.judge(evidence).findings}

    assert found["x"].details["local_order"] == pytest.approx(1.0, abs=0.05)
    if mesh == "at mesh points":
        assert found["y"].verdict is Verdict.INCONCLUSIVE
        assert found["y"].details["local_order"] == pytest.approx(1.0, abs=0.05)
    else:
        assert found["y"].verdict is Verdict.REFUTED
        assert found["y"].details["local_order"] == pytest.approx(0.5, abs=0.01)
