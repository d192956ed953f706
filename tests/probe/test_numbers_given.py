"""Times and step sizes are Python floats in every tier: what a step prints or hands on is a plain number."""

from typing import ClassVar

import pytest

from sdaeverify import SDE, Claim, Scheme, Step, verify
from sdaeverify_orders import orders


class Printing(Scheme):
    """Euler-Maruyama that hands its time and step size on as text, as an adapter of an executable does."""

    name: ClassVar[str] = "printing"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = tuple(
        Claim(measure=measure, value=value, source="made up")
        for measure, value in (("weak", 1.0), ("strong", 0.5), ("invariant", 1.0), ("stability", "conditional"))
    )
    given: ClassVar[set[str]] = set()

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        self.given.update(type(number).__name__ for number in (t, h))
        t, h = float(repr(t)), float(repr(h))
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


@pytest.mark.long
def test_a_step_is_given_python_floats():
    """No tier of any measure, and no order condition, gives a number of another type; arrays over paths are tried."""
    found = verify(Printing(), ["ou", "gbm"], ["weak", "strong", "invariant", "stability"], paths=256)
    orders(Printing(), motions=2)

    assert "error" not in set(found.verdicts.verdict)
    assert Printing.given <= {"float", "ndarray"}
