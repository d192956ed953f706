"""Methods of QuTiP as schemes; skipped where it is not installed."""

from dataclasses import replace

import numpy as np
import pytest

from bridges.equations import PATHS, H, drawn
from facade import (
    forced_ou,
    gbm,
    hyperbolic_pair,
    noncommuting,
    ou,
)
from sdaeverify_bridges.qutip import ORDERS, QuTiP

pytest.importorskip("qutip", reason="needs the extra: pip install .[qutip]")


def test_second_variable_is_the_time_integral():
    """For dx = a x dt + b dW, Taylor's method of order 1.5 adds a b int W ds = a b h (dW/2 + H)."""
    problem, x = ou(), np.zeros((1, PATHS))
    noise = drawn(problem, H, PATHS)

    found = QuTiP("taylor1.5").step(problem, x, 0.5, H, noise).state
    np.testing.assert_allclose(found, 0.7 * (noise.dW - H * (0.5 * noise.dW + noise.H)), rtol=0.0, atol=1e-15)


def test_equations_that_are_not_linear_are_refused():
    """A coefficient that bends or depends on time is no matrix."""
    late = replace(gbm(), drift=lambda t, x: (0.5 + t) * x)
    assert "is not linear" in QuTiP().refuses(hyperbolic_pair())
    assert all("depends on time" in QuTiP().refuses(problem) for problem in (forced_ou(), late))


def test_noise_that_needs_areas_is_for_euler():
    """As the documentation has it, the other methods are for noise that commutes."""
    assert not QuTiP().refuses(noncommuting())
    assert all(QuTiP(method).refuses(noncommuting()) for method in ORDERS if method != "euler")
