"""Relaxation times against the gap of the generator, by Galerkin's method under the invariant law."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from facade import angle_pendulum, damped_pendulum, double_well, ellipse
from problems.generator import generator
from sdaeverify import Array, Problem

TURN = 2 * np.pi * np.arange(128) / 128


class Case(NamedTuple):
    """A problem, nodes and weights of its invariant law, functions (d, P) -> (k, P), and the accuracy promised."""

    problem: Problem
    x: Array
    weights: Array
    basis: Callable[[Array], Array]
    accuracy: float


def turns(x: Array) -> Array:
    """Return trigonometric polynomials of the eccentric angle to degree 14."""
    theta, k = np.arctan2(x[1], 0.5 * x[0]), np.arange(1, 15)[:, None]
    return np.concatenate([np.ones((1, x.shape[1])), np.cos(k * theta), np.sin(k * theta)])


def powers(x: Array) -> Array:
    """Return Chebyshev polynomials to degree 24 on [-2.5, 2.5], where all but 1e-9 of the laws is."""
    return np.polynomial.chebyshev.chebvander(x[0] / 2.5, 24).T


def on_the_ellipse(measure: str, density: Array) -> Case:
    problem = ellipse(measure)
    return Case(problem, problem.chart.embed(TURN[None]), density, turns, 1e-6)


def in_the_well(sigma: float, end: float) -> Case:
    """Return the law exp((x^2 - x^4/2)/sigma^2); central differences on the grid promise a thousandth."""
    x = np.linspace(-end, end, 801)
    return Case(double_well(sigma), x[None], np.exp((x**2 - 0.5 * x**4) / sigma**2), powers, 2e-3)


CASES: dict[str, Callable[[], Case]] = {
    "ellipse, arc": lambda: on_the_ellipse("arc", np.hypot(2.0 * np.sin(TURN), np.cos(TURN))),
    "ellipse, delta": lambda: on_the_ellipse("delta", np.ones(128)),
    "double well": lambda: in_the_well(1.0, 4.0),
    "double well, cold": lambda: in_the_well(0.5, 3.0),
}


def least(rates: Array) -> float:
    """Return the least positive real part of eigenvalues."""
    return float(np.sort(rates.real[rates.real > 1e-6])[0])


@pytest.mark.parametrize("name", CASES)
def test_relaxation_is_the_gap_of_the_generator(name: str) -> None:
    """The relaxation time is the reciprocal of the least positive eigenvalue of -L in a space of functions."""
    problem, x, weights, basis, accuracy = CASES[name]()
    values = basis(x)
    images = np.stack([generator(problem, lambda x, k=k: basis(x)[k], x) for k in range(len(values))])
    L = np.linalg.solve((values * weights) @ values.T, (values * weights) @ images.T)

    assert problem.relaxation_time == pytest.approx(1.0 / least(-np.linalg.eigvals(L)), rel=accuracy)


def rotor_gap(c_g: float, gamma: float, kT: float, mass: float) -> float:
    """Return the gap of the generator in functions e^{ik theta} He_n(s), s = omega sqrt(<t, M t>/kT), by quadrature.

    With J = <t, M t> the momentum p = sqrt(J) omega has the drift -(c_g sin + gamma p/sqrt(J))/sqrt(J) and the noise
    sqrt(2 gamma kT/J), and theta has p/sqrt(J); the density of theta is sqrt(J) exp(c_g cos/kT).
    """
    J, k, n = np.cos(TURN) ** 2 + mass * np.sin(TURN) ** 2, np.arange(-6, 7), np.arange(9)
    density = np.sqrt(J) * np.exp(c_g * (np.cos(TURN) - 1.0) / kT)
    wave = np.exp(1j * k[:, None] * TURN)
    lower = np.diag(np.sqrt(n[1:]), 1)

    def mean(values: Array) -> Array:
        return (wave.conj() * values * density) @ wave.T / density.sum()

    # s' = -c_g sin/sqrt(J kT) - gamma s/J + sqrt(2 gamma/J) dbeta, and theta' = sqrt(kT/J) s.
    turn = np.kron(mean(np.sqrt(kT / J)) * 1j * k, lower + lower.T)
    pull = np.kron(mean(c_g * np.sin(TURN) / np.sqrt(J * kT)), lower)
    L = turn - pull - gamma * np.kron(mean(1.0 / J), np.diag(n))
    return least(-np.linalg.eigvals(np.linalg.solve(np.kron(mean(np.ones(128)), np.eye(9)), L)))


@pytest.mark.sweep
@pytest.mark.parametrize(("gamma", "c"), [(0.3, 0.0), (0.3, 1.0), (1.0, 0.3), (5.0, 0.0), (5.0, 1.0)])
@pytest.mark.parametrize("mass", [0.3, 1.0, 4.0])
def test_relaxation_of_a_pendulum_is_estimated_to_its_size(gamma: float, c: float, mass: float) -> None:
    """Estimates are 2/3, or without masses 3/4, to 5, or 3, times the reciprocal of the generator's gap."""
    gap = rotor_gap(c, gamma, 0.5, mass)

    assert 2 / 3 <= damped_pendulum(c_g=c, gamma=gamma, mass=mass).relaxation_time * gap <= 5.0
    if mass == 1.0:
        assert 0.75 <= angle_pendulum(c=c, gamma=gamma, sigma=np.sqrt(gamma)).relaxation_time * gap <= 3.0
