"""The damped pendulum with a mass matrix: its angle form, its relaxation time, and that schemes find its law."""

import numpy as np
import pytest

from facade import damped_pendulum
from sdaeverify import Array


def inertia(theta: Array, mass: float) -> Array:
    """Return <t, M t>."""
    return np.asarray(np.cos(theta) ** 2 + mass * np.sin(theta) ** 2)


def rotor_gap(c_g: float, gamma: float, kT: float, mass: float) -> float:
    """Return the gap of the generator in functions e^{ik theta} He_n(s), s = omega sqrt(<t, M t>/kT), by quadrature.

    With J = <t, M t> the momentum p = sqrt(J) omega has the drift -(c_g sin + gamma p/sqrt(J))/sqrt(J) and the noise
    sqrt(2 gamma kT/J), and theta has p/sqrt(J); the density of theta is sqrt(J) exp(c_g cos/kT).
    """
    theta = 2 * np.pi * np.arange(128) / 128
    J, k, n = inertia(theta, mass), np.arange(-6, 7), np.arange(9)
    density = np.sqrt(J) * np.exp(c_g * (np.cos(theta) - 1.0) / kT)
    wave = np.exp(1j * k[:, None] * theta)
    lower = np.diag(np.sqrt(n[1:]), 1)

    def mean(values: Array) -> Array:
        return (wave.conj() * values * density) @ wave.T / density.sum()

    # s' = -c_g sin/sqrt(J kT) - gamma s/J + sqrt(2 gamma/J) dbeta, and theta' = sqrt(kT/J) s.
    turn = np.kron(mean(np.sqrt(kT / J)) * 1j * k, lower + lower.T)
    pull = np.kron(mean(c_g * np.sin(theta) / np.sqrt(J * kT)), lower)
    L = turn - pull - gamma * np.kron(mean(1.0 / J), np.diag(n))
    rates = np.sort(-np.linalg.eigvals(np.linalg.solve(np.kron(mean(np.ones(128)), np.eye(9)), L)).real)
    return float(rates[rates > 1e-6][0])


@pytest.mark.parametrize("mass", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("c_g", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("gamma", [0.3, 1.0, 5.0])
def test_relaxation_is_estimated_to_its_size(gamma: float, c_g: float, mass: float) -> None:
    """The estimate is between 2/3 of and 5 times the reciprocal of the generator's gap."""
    problem = damped_pendulum(c_g=c_g, gamma=gamma, mass=mass)

    assert 2 / 3 <= problem.relaxation * rotor_gap(c_g, gamma, 0.5, mass) <= 5.0
