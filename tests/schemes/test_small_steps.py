"""Schemes of a positive weak order are stable in mean square for small steps, and claim it."""

from typing import ClassVar

import pytest

from sdaeverify import SDE, Claim, Scheme, Step, verify
from sdaeverify.numerics import apply

# Stable in mean square in Ito's sense, 2 a + s^2 = -0.5, and unstable in Stratonovich's, 2 a + 2 s^2 = 1.
STABLE_IN_ITO = "gbm[a=-1,b=1.224744871391589]"


class WithoutCorrection(Scheme):
    """Heun's scheme for the Ito drift: it solves the equation in Stratonovich's sense, which is another one."""

    name: ClassVar[str] = "heun-without-correction"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="stability", value="conditional", source="test"),)

    def step(self, problem, state, t, h, noise):
        f, B = problem.drift(t, state), problem.diffusion(t, state)
        y = state + h * f + apply(B, noise.dW)
        F, C = problem.drift(t + h, y), problem.diffusion(t + h, y)
        return Step(state + 0.5 * (h * (f + F) + apply(B + C, noise.dW)))


@pytest.mark.parametrize("scheme", ["balanced-euler", "heun", "platen-weak-2", "euler-maruyama"])
def test_small_steps_are_stable(scheme):
    """Where the equation is, though its noise is so strong that in Stratonovich's sense it is not."""
    (row,) = verify(scheme, STABLE_IN_ITO, "stability").rows.verdicts

    assert (row.claim, row.verdict) == ("conditional", "verified")
    assert row.value > 0.0


def test_a_scheme_for_another_equation_is_refuted():
    """Its second moments grow at small steps: the claim is no mere consequence of the measure."""
    (row,) = verify(WithoutCorrection(), STABLE_IN_ITO, "stability").rows.verdicts

    assert row.verdict == "refuted"
    assert row.reason.startswith("Unstable for small h")
