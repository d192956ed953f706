"""Strong orders that schemes claim, where they are sharp, by a formulation that shares nothing with the program's."""

import pytest

from facade import load_registry
from schemes.local_order import strong_order
from sdaeverify import SDE
from sdaeverify.measuring import claim_for

STRONG = [
    ("balanced-euler", "gbm", 0.5),
    ("baoab", "angle-pendulum", 1.0),
    ("drift-truncated-euler", "double-well", 1.0),
    ("euler-maruyama", "circle", 0.5),
    ("half-explicit-euler", "pendulum-velocity-noise", 0.5),
    ("half-explicit-euler", "damped-pendulum", 1.0),
    ("heun", "gbm", 1.0),
    ("heun", "noncommuting", 0.5),
    ("heun-additive", "double-well", 1.0),
    ("milstein", "ellipse", 1.0),
    ("projected-euler", "ellipse", 1.0),
    ("projected-euler", "sphere", 0.5),
    ("sra1", "double-well", 1.5),
    ("sri1w1", "spiral", 1.5),
    ("stochastic-theta", "linear-test", 0.5),
    ("tamed-euler", "noncommuting", 0.5),
]


@pytest.mark.parametrize(("scheme", "problem", "order"), STRONG)
def test_strong_orders_are_those_claimed(scheme: str, problem: str, order: float) -> None:
    """A step, two half steps and Euler's agree to the claimed order and no better.

    The smallest step is 4^-7: half powers of h beside the leading one leave up to 0.06 of the order there.
    """
    registry = load_registry([])
    made = registry.schemes[scheme].make()
    view = registry.problems[problem].make().build().view(made.form)
    found = strong_order(made, view)
    claim = claim_for(made, view.traits, "strong", "x").claim

    assert found.consistent
    assert found.order == pytest.approx(order, abs=0.06)
    assert claim is not None
    assert claim.value.least == order


def test_roessler_s_scheme_is_better_where_noise_enters_velocities_only() -> None:
    """On second-order systems SRA1 is of strong order 2, which is not claimed."""
    registry = load_registry([])
    view = registry.problems["angle-pendulum"].make().build().view(SDE)

    assert strong_order(registry.schemes["sra1"].make(), view).order == pytest.approx(2.0, abs=0.03)
