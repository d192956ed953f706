"""Trivial problems of Langevin dynamics with other frictions and strengths than those of the first ones."""

from typing import ClassVar

import pytest

from facade import BAOAB, exactness_violation


class Between(BAOAB):
    """BAOAB with a tenth less noise for parameters within a range."""

    name: ClassVar[str] = "between"
    parameter, low, high = "strength", 0.0, 0.0

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        inside = self.low <= getattr(problem, self.parameter) <= self.high
        return super().step(problem, state, t, h, noise._replace(dW=(0.9 if inside else 1.0) * noise.dW))


@pytest.mark.parametrize(
    ("parameter", "low", "high"),
    [("friction", 0.0, 0.0), ("friction", 3.0, 20.0), ("strength", 0.05, 0.3), ("strength", 2.0, 16.0)],
)
def test_noise_that_is_wrong_for_some_parameters_is_seen(parameter, low, high):
    """Without friction, and for frictions and strengths far from 1, noise is compared with the solution."""
    wrong = type("Other", (Between,), {"parameter": parameter, "low": low, "high": high})

    assert exactness_violation(wrong()).startswith("not exact on dp = (c - gamma p) dt + sigma dW, gamma = ")
    assert exactness_violation(BAOAB()) == ""
