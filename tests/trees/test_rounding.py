"""How far the conditions of right schemes are from holding: roundings, Newton's method, Taylor series."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import CLASSES, Examined, belongs, load_plugins, probe_of, select_schemes
from sdaeverify import Step
from sdaeverify.numerics import apply
from sdaeverify_orders import orders
from sdaeverify_schemes.milstein import Milstein

BY_NAME = {kind.name: kind for kind in CLASSES}
# Scheme, class, motions, measure, order and a bound: of roundings, of updates of Newton's method, of a Taylor series.
EXACT, NEWTON, SERIES = 1e-10, 1e-9, 1e-5
RIGHT = [
    ("sri1w1", "scalar", 1, "strong", 1.5, EXACT),
    ("sra1", "additive", 2, "strong", 1.5, EXACT),
    ("sra1", "additive", 2, "weak", 2.0, EXACT),
    ("sra1", "overdamped-gradient", 2, "invariant", 2.0, EXACT),
    ("milstein", "scalar", 1, "strong", 1.0, EXACT),
    ("milstein-areas", "general", 3, "strong", 1.0, EXACT),
    ("heun", "commutative", 2, "strong", 1.0, EXACT),
    ("heun-additive", "additive", 2, "weak", 2.0, EXACT),
    ("platen-weak-2", "scalar", 1, "weak", 2.0, EXACT),
    ("platen-weak-2-general", "general", 2, "weak", 2.0, EXACT),
    ("stochastic-theta", "additive", 2, "weak", 2.0, NEWTON),
    ("stochastic-theta", "scalar", 1, "weak", 1.0, NEWTON),
    ("milstein", "diagonal", 2, "strong", 1.0, SERIES),
    ("heun", "diagonal", 2, "weak", 1.0, SERIES),
]


@pytest.mark.parametrize(("name", "kind", "motions", "measure", "order", "bound"), RIGHT)
def test_conditions_of_right_schemes_hold_to_rounding(name, kind, motions, measure, order, bound):
    """In units of h^(w/2) no defect is larger than its method makes it."""
    (scheme,) = select_schemes(load_plugins(), name)
    of = Examined(probe_of(scheme, BY_NAME[kind], motions, int(2 * order + 1)))
    asked = [each.defect for each in of.found if belongs(each, measure, order)]

    assert asked
    assert max(asked) <= bound


@dataclass(frozen=True)
class NearlyMilstein(Milstein):
    """Milstein's scheme for diagonal noise with increments of another mean or size, or a factor of its correction."""

    name: ClassVar[str] = "nearly-milstein"

    mean: float = 0.0
    size: float = 1.0
    factor: float = 1.0

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        B = problem.diffusion(t, state)
        DB = problem.derivative_of_diffusion(t, state, np.einsum("jjp->jp", B))
        correction = 0.5 * self.factor * np.einsum("jjp->jp", DB) * (noise.dW**2 - h)
        dW = self.size * noise.dW + self.mean * np.sqrt(h)
        return Step(state + h * problem.drift(t, state) + apply(B, dW) + correction)


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("scheme", "strong", "weak"),
    [
        (NearlyMilstein(), 1.0, 1.0),
        (NearlyMilstein(mean=1e-6), 0.0, 0.0),
        (NearlyMilstein(size=1.0 + 1e-6), 0.0, 0.0),
        (NearlyMilstein(factor=1.0 + 1e-6), 0.5, 1.0),
    ],
    ids=["right", "mean", "size", "factor"],
)
def test_small_mistakes_are_seen_for_diagonal_noise(scheme, strong, weak):
    """The tolerance of a weight is its own rounding error: it is small for the trees on which low orders depend."""
    table = orders(scheme, "diagonal", 2).table.set_index("measure")

    assert (table.order["strong"], table.order["weak"]) == (strong, weak)
    assert (table.verdict["strong"] == "verified") is (strong == 1.0)
    assert (table.verdict["weak"] == "verified") is (weak == 1.0)
