"""Simulations that truths are compared with: Euler's scheme written once more, and solutions on the same paths."""

import numpy as np
import pytest

from facade import Inapplicable, delay_martingale, gbm, ou
from sdaeverify import Problem
from sdaeverify.probing import Source, brownian_steps
from sdaeverify.testing.checks.sampled import COARSEST, euler_walker, walk_together


def test_euler_walks_on_the_named_noise():
    """At T it is where Euler's scheme leads on the Brownian paths drawn by the problem's name."""
    problem, walker = gbm(), euler_walker(gbm(), 1, 4)
    steps = brownian_steps(Source(1, "gbm in the kit", 0, 4), 1, problem.horizon / COARSEST, 1)
    x, h = np.ones((1, 4)), problem.horizon / (2 * COARSEST)
    for _, (_, fine) in zip(range(COARSEST), steps, strict=False):
        for dW in fine.dW:
            x = x + h * 0.5 * x + 0.6 * x * dW

    times = list(walk_together(problem, "gbm", [walker], 4))

    assert times == [0.5, 1.0]
    np.testing.assert_allclose(walker.parts(1.0)["x"], x, rtol=1e-13)


def test_mirrored_paths_have_opposite_noise():
    """For a linear equation with additive noise, means over a path and its mirror image have no noise at all."""
    walker = euler_walker(ou(), 0, 8)
    list(walk_together(ou(), "ou", [walker], 8, mirrored=True))
    x = walker.parts(1.0)["x"][0]

    np.testing.assert_allclose(x[:4] + x[4:], 2.0 * (1.0 - 1.0 / COARSEST) ** COARSEST, rtol=1e-13)


def test_a_delay_is_looked_up():
    """Up to the first delay, noise times the history is a sum of increments."""
    problem = delay_martingale(horizon=1.0)
    walker = euler_walker(problem, 0, 3)
    steps = brownian_steps(Source(1, "delay-martingale in the kit", 0, 3), 1, 1.0 / COARSEST, 0)
    W = sum(level.dW[0] for _, (level,) in zip(range(COARSEST), steps, strict=False))
    list(walk_together(problem, "delay-martingale", [walker], 3))

    np.testing.assert_allclose(walker.parts(1.0)["x"], 1.0 + 0.8 * W, rtol=1e-13)


def test_what_has_no_equation_is_not_simulated():
    """A form without an Ito equation has nothing to compare with."""
    formless = Problem(horizon=1.0, noise_dim=1, source="a test")

    with pytest.raises(Inapplicable, match="no Ito equation"):
        euler_walker(formless, 0, 1)
