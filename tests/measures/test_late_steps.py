"""Claims about all times, and steps that are other ones from a late time or a late step on."""

from typing import ClassVar

import numpy as np
import pytest

from facade import BAOAB, MALA, EulerMaruyama, late_change
from sdaeverify import SDE, Step, verify
from sdaeverify.probing import OneStep


class LateNoise(BAOAB):
    """BAOAB with a tenth less noise after twenty units of time."""

    name: ClassVar[str] = "late-noise"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=(0.9 if t > 20.0 else 1.0) * noise.dW))


class AdjustedAtFirst(MALA):
    """MALA that accepts each proposal from the 500th step on."""

    name: ClassVar[str] = "adjusted-at-first"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        if round(t / h) < 500:
            return super().step(problem, state, t, h, noise)
        return Step(problem.euler(t, state, h, noise))


def verdicts(scheme, problem, measure):
    """Return the verdicts on the claims of a measure, and one of their reasons."""
    table = verify([scheme], [problem], [measure], paths=1024).verdicts
    table = table[(table.scheme == scheme.label) & table.claim.notna()]
    return {*map(str, table.verdict)}, str(table.reason.iloc[0])


@pytest.mark.parametrize(
    ("wrong", "right", "problem", "measure"),
    [
        (LateNoise(), BAOAB(), "harmonic-langevin", "invariant"),
        (LateNoise(), BAOAB(), "harmonic-langevin", "stability"),
        (AdjustedAtFirst(), MALA(), "ou", "invariant"),
    ],
)
def test_claims_about_all_times_are_not_verified_if_late_steps_are_other_ones(wrong, right, problem, measure):
    """Stationary laws and stability rest on one step; it has to be the same one after the horizon."""
    found, reason = verdicts(wrong, problem, measure)

    assert found == {"inconclusive"}
    assert "the claim is about all times" in reason
    assert verdicts(right, problem, measure)[0] == {"verified"}


def moving(rate):
    """Return an equation whose drift turns with the given rate in time."""
    return SDE(
        drift=lambda t, x: np.cos(rate * t) - x,
        diffusion=lambda t, x: np.ones((1, 1, 1)),
        start=[0.0],
        noise_dim=1,
        horizon=1.0,
        source="test",
    )


@pytest.mark.parametrize("rate", [0.0, 3.0])
def test_steps_of_a_right_scheme_change_only_with_the_equation(rate):
    """No late time is found, whether the equation depends on time or not."""
    assert np.isnan(late_change(OneStep(EulerMaruyama(), moving(rate))).late)
