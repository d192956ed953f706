"""Langevin integrators of ASE as schemes; skipped where it is not installed."""

from dataclasses import replace

import numpy as np
import pytest

from bridges.equations import drawn
from facade import BAOAB, angle_pendulum, harmonic_langevin
from sdaeverify import Increment, ParameterError
from sdaeverify_bridges.ase import ASE, CLAIMS

H, PATHS, EPS = 0.125, 7, np.finfo(float).eps


@pytest.fixture(scope="module", autouse=True)
def library():
    """Skip where ASE is not installed."""
    return pytest.importorskip("ase", reason="ASE is not installed; pip install '.[ase]'")


@pytest.mark.parametrize("family", [angle_pendulum, harmonic_langevin], ids=lambda family: family.__name__)
def test_baoab_is_ours_to_rounding(family):
    """On the same noise LangevinBAOAB makes the step that ours makes."""
    problem = family()
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    found, expected = (s.step(problem, x, 0.5, H, noise).state for s in (ASE("LangevinBAOAB"), BAOAB()))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * EPS * np.abs(expected).max())


def test_noise_of_langevin_is_dw_and_its_integral():
    """Without force and all but without friction, p moves by sigma dW and q by sigma h (dW/2 + H)."""
    gamma = 1e-9
    problem, x = angle_pendulum(c=0.0, gamma=gamma), np.zeros((2, PATHS))
    noise = drawn(problem, H, PATHS)

    q, p = ASE().step(problem, x, 0.5, H, noise).state
    np.testing.assert_allclose(p, problem.strength * noise.dW[0], rtol=10.0 * gamma)
    np.testing.assert_allclose(q, problem.strength * H * (0.5 * noise.dW + noise.H)[0], rtol=10.0 * gamma)


@pytest.mark.parametrize("integrator", CLAIMS)
def test_paths_do_not_see_each_other(integrator):
    """A path among others is the same to the last bit as that path alone."""
    problem, scheme = angle_pendulum(), ASE(integrator)
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    alone = Increment(noise.dW[:, 4:5], noise.H[:, 4:5])
    found = scheme.step(problem, x, 0.5, H, noise).state[:, 4:5]
    np.testing.assert_array_equal(scheme.step(problem, x[:, 4:5], 0.5, H, alone).state, found)


def test_dynamics_without_temperature_are_refused():
    """ASE is given a temperature and a friction."""
    assert ASE().refuses(replace(angle_pendulum(), friction=0.0, truths=()))
    assert not ASE().refuses(angle_pendulum())


def test_integrator_is_checked():
    """An integrator whose noise has no increments is refused."""
    with pytest.raises(ParameterError, match="integrator must be one of Langevin, LangevinBAOAB, got 'Andersen'"):
        ASE("Andersen")
