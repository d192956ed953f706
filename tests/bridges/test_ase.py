"""Langevin integrators of ASE as schemes; skipped where it is not installed."""

from dataclasses import replace

import numpy as np
import pytest

from bridges.equations import PATHS, H, drawn
from facade import angle_pendulum
from sdaeverify_bridges.ase import ASE

pytest.importorskip("ase", reason="needs the extra: pip install .[ase]")


def test_noise_of_langevin_is_dw_and_its_integral():
    """Without force and all but without friction, p moves by sigma dW and q by sigma h (dW/2 + H)."""
    gamma = 1e-9
    problem, x = angle_pendulum(c=0.0, gamma=gamma), np.zeros((2, PATHS))
    noise = drawn(problem, H, PATHS)

    q, p = ASE().step(problem, x, 0.5, H, noise).state
    np.testing.assert_allclose(p, problem.strength * noise.dW[0], rtol=10.0 * gamma)
    np.testing.assert_allclose(q, problem.strength * H * (0.5 * noise.dW + noise.H)[0], rtol=10.0 * gamma)


def test_dynamics_without_temperature_are_refused():
    """ASE is given a temperature and a friction."""
    assert ASE().refuses(replace(angle_pendulum(), friction=0.0, truths=()))
    assert not ASE().refuses(angle_pendulum())
