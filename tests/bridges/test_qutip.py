"""Methods of QuTiP as schemes; skipped where it is not installed."""

from dataclasses import replace

import numpy as np
import pytest

from bridges.equations import drawn
from facade import (
    EulerMaruyama,
    Milstein,
    forced_ou,
    gbm,
    harmonic_langevin,
    hyperbolic_pair,
    noncommuting,
    ou,
    spiral,
)
from sdaeverify import SDE, Increment, ParameterError
from sdaeverify_bridges.qutip import ORDERS, QuTiP

H, PATHS, EPS = 0.125, 7, np.finfo(float).eps


@pytest.fixture(scope="module", autouse=True)
def library():
    """Skip where QuTiP is not installed."""
    return pytest.importorskip("qutip", reason="QuTiP is not installed; pip install '.[qutip]'")


@pytest.mark.parametrize(
    ("method", "ours", "family"),
    [
        ("euler", EulerMaruyama(), gbm),
        ("euler", EulerMaruyama(), noncommuting),
        ("euler", EulerMaruyama(), harmonic_langevin),
        ("milstein", Milstein(), gbm),
        ("milstein", Milstein(), ou),
    ],
)
def test_our_schemes_agree_to_rounding(method, ours, family):
    """On the same noise QuTiP makes the step that ours makes, constants and all."""
    problem = family().view(SDE)
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    found, expected = (scheme.step(problem, x, 0.5, H, noise).state for scheme in (QuTiP(method), ours))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * EPS * np.abs(expected).max())


def test_second_variable_is_the_time_integral():
    """For dx = a x dt + b dW, Taylor's method of order 1.5 adds a b int W ds = a b h (dW/2 + H)."""
    problem, x = ou(), np.zeros((1, PATHS))
    noise = drawn(problem, H, PATHS)

    found = QuTiP("taylor1.5").step(problem, x, 0.5, H, noise).state
    np.testing.assert_allclose(found, 0.7 * (noise.dW - H * (0.5 * noise.dW + noise.H)), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("method", ORDERS)
def test_paths_do_not_see_each_other(method):
    """A path among others is the same to the last bit as that path alone."""
    problem, scheme = spiral(), QuTiP(method)
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    alone = Increment(noise.dW[:, 4:5], noise.H[:, 4:5])
    found = scheme.step(problem, x, 0.5, H, noise).state[:, 4:5]
    np.testing.assert_array_equal(scheme.step(problem, x[:, 4:5], 0.5, H, alone).state, found)


def test_equations_that_are_not_linear_are_refused():
    """A coefficient that bends or depends on time is no matrix."""
    late = replace(gbm(), drift=lambda t, x: (0.5 + t) * x)
    assert "is not linear" in QuTiP().refuses(hyperbolic_pair())
    assert all("depends on time" in QuTiP().refuses(problem) for problem in (forced_ou(), late))


def test_noise_that_needs_areas_is_for_euler():
    """As the documentation has it, the other methods are for noise that commutes."""
    assert not QuTiP().refuses(noncommuting())
    assert all(QuTiP(method).refuses(noncommuting()) for method in ORDERS if method != "euler")


def test_method_is_checked():
    """A method for density matrices alone is refused."""
    with pytest.raises(ParameterError, match=r"method must be one of euler, .*, got 'rouchon'"):
        QuTiP("rouchon")
