"""Invariant laws: nodes and weights of each law, the means it gives, and that the equation leaves it as it is.

A law pi is invariant if the integral of L q vanishes for all smooth q, L being the generator of the Ito equation:
that ties means, which come from quadrature, to drift and diffusion, which do not.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from facade import angle_pendulum, circle, damped_pendulum, double_well, ellipse, ou, sphere
from problems.generator import generator
from sdaeverify import Array, Problem

TURN = 2 * np.pi * np.arange(128) / 128


class Law(NamedTuple):
    """Nodes and weights of a probability measure on states, shapes (d, P) and (P,)."""

    x: Array
    weights: Array


def normalised(x: Array, weights: Array) -> Law:
    return Law(x, weights / weights.sum())


def on_a_curve(problem: Problem, density: Array) -> Law:
    assert problem.chart is not None
    return normalised(problem.chart.embed(TURN[None]), density)


def on_the_sphere() -> Law:
    z, w = np.polynomial.legendre.leggauss(20)
    z, phi, w = (part.ravel() for part in np.broadcast_arrays(z[:, None], TURN[None], w[:, None]))
    return normalised(np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z]), w)


def on_the_line(density: Callable[[Array], Array], end: float) -> Law:
    x = np.linspace(-end, end, 801)
    return normalised(x[None], density(x))


def of_a_rotor(problem: Problem, c: float, kT: float) -> Law:
    """Return the nodes for von Mises' law times a normal law, embedded in the problem's states."""
    assert problem.chart is not None
    nodes, weights = np.polynomial.hermite_e.hermegauss(16)
    theta, omega = np.meshgrid(TURN, np.sqrt(kT) * nodes, indexing="ij")
    density = np.exp(c / kT * np.cos(theta)) * weights
    return normalised(problem.chart.embed(np.stack([theta.ravel(), omega.ravel()])), density.ravel())


def arc(theta: Array) -> Array:
    return np.hypot(2.0 * np.sin(theta), np.cos(theta))


CASES: dict[str, Callable[[], tuple[Problem, Law]]] = {
    "circle": lambda: (circle(), on_a_curve(circle(), np.ones(128))),
    "sphere": lambda: (sphere(), on_the_sphere()),
    "ellipse, arc": lambda: (ellipse(), on_a_curve(ellipse(), arc(TURN))),
    "ellipse, delta": lambda: (ellipse("delta"), on_a_curve(ellipse("delta"), np.ones(128))),
    "double well": lambda: (double_well(), on_the_line(lambda x: np.exp(x**2 - 0.5 * x**4), 4.0)),
    "double well, cold": lambda: (double_well(0.5), on_the_line(lambda x: np.exp(4 * x**2 - 2 * x**4), 3.0)),
    "ou": lambda: (ou(1.5, 0.6), on_the_line(lambda x: np.exp(-1.5 * x**2 / 0.36), 5.0)),
    "angle pendulum": lambda: (angle_pendulum(), of_a_rotor(angle_pendulum(), 1.0, 0.49)),
    "damped pendulum": lambda: (damped_pendulum(), of_a_rotor(damped_pendulum(), 1.0, 0.5)),
    "damped rotor": lambda: (damped_pendulum(0.0), of_a_rotor(damped_pendulum(0.0), 0.0, 0.5)),
}


def gap(problem: Problem, basis: Callable[[Array], Array], law: Law) -> float:
    """Return the least positive eigenvalue of -L in a space of functions (k, P), by Galerkin's method under a law."""
    count = len(basis(law.x[:, :1]))
    images = np.stack([generator(problem, lambda x, k=k: basis(x)[k], law.x) for k in range(count)])
    values = basis(law.x)
    L = np.linalg.solve((values * law.weights) @ values.T, (values * law.weights) @ images.T)
    eigenvalues = np.sort(-np.linalg.eigvals(L).real)
    return float(eigenvalues[eigenvalues > 1e-6][0])


def turns(x: Array) -> Array:
    """Return trigonometric polynomials of the eccentric angle to degree 14."""
    theta = np.arctan2(x[1], 0.5 * x[0])
    k = np.arange(1, 15)[:, None]
    return np.concatenate([np.ones((1, x.shape[1])), np.cos(k * theta), np.sin(k * theta)])


def powers(x: Array) -> Array:
    """Return Chebyshev polynomials to degree 24 on [-2.5, 2.5], where all but 1e-9 of the laws is."""
    return np.polynomial.chebyshev.chebvander(x[0] / 2.5, 24).T


@pytest.mark.parametrize("name", ["ellipse, arc", "ellipse, delta"])
def test_relaxation_on_the_ellipse_is_the_gap_of_the_generator(name: str) -> None:
    """The relaxation time is the reciprocal of the gap, to the resolution of the trigonometric polynomials."""
    problem, law = CASES[name]()

    assert problem.relaxation == pytest.approx(1.0 / gap(problem, turns, law), rel=1e-6)


@pytest.mark.parametrize("name", ["double well", "double well, cold"])
def test_relaxation_in_the_double_well_is_the_gap_of_the_generator(name: str) -> None:
    """Central differences on the grid and Galerkin's method agree to the thousandth promised."""
    problem, law = CASES[name]()

    assert problem.relaxation == pytest.approx(1.0 / gap(problem, powers, law), rel=2e-3)


def rotor_gap(c: float, gamma: float, kT: float) -> float:
    """Return the gap of p d_q - c sin q d_p - gamma p d_p + gamma kT d_pp in functions e^{ikq} He_n(p/sqrt(kT))."""
    k, n, s = np.arange(-4, 5), np.arange(9), np.sqrt(kT)
    lower = np.diag(np.sqrt(n[1:]), 1)
    sine = (np.eye(9, k=-1) - np.eye(9, k=1)) / 2j
    L = np.kron(1j * np.diag(k), s * (lower + lower.T)) - np.kron(c * sine, lower / s)
    eigenvalues = np.sort(-np.linalg.eigvals(L - gamma * np.kron(np.eye(9), np.diag(n))).real)
    return float(eigenvalues[eigenvalues > 1e-6][0])


@pytest.mark.parametrize("c", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("gamma", [0.3, 1.0, 5.0])
def test_relaxation_of_the_rotor_is_estimated_to_its_size(c: float, gamma: float) -> None:
    """The estimate is between 3/4 of and 3 times the reciprocal of the generator's gap."""
    problem = angle_pendulum(c=c, gamma=gamma, sigma=np.sqrt(gamma))

    assert 0.75 <= problem.relaxation * rotor_gap(c, gamma, 0.5) <= 3.0
