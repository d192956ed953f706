"""The damped pendulum with a mass matrix: its angle form, its relaxation time, and that schemes find its law."""

from dataclasses import replace

import numpy as np
import pytest

from sdaeverify import SDE, HolonomicSDAE, InvariantMean, ParameterError, Pathwise, verify
from sdaeverify.arrays import Array
from sdaeverify_problems import _circle as circle
from sdaeverify_problems._canonical_law import Canonical, circle_nodes
from sdaeverify_problems.damped_pendulum import damped_pendulum

EPS = np.finfo(float).eps


def inertia(theta: Array, mass: float) -> Array:
    """Return <t, M t>."""
    return np.asarray(np.cos(theta) ** 2 + mass * np.sin(theta) ** 2)


@pytest.mark.parametrize("mass", [1.0, 0.3, 2.5])
def test_the_angle_form_is_the_inherent_equation(mass: float) -> None:
    """With v = omega t: <t, M t> domega = (omega^2 <t, M r> - c_g sin - gamma omega) dt + sigma <t, dw>."""
    problem, rng = damped_pendulum(c_g=1.3, gamma=0.7, kT=0.4, mass=mass), np.random.default_rng(4)
    theta, omega = rng.uniform(-3, 3, 20), rng.standard_normal(20)
    r, t = circle.normal(theta), circle.tangent(theta)
    view = problem.view(SDE)
    x = np.concatenate([r, omega * t])
    B = np.broadcast_to(view.diffusion(0.0, x), (4, 2, 20))
    coupling = (t * np.array([[1.0], [mass]]) * r).sum(axis=0)

    rate = (omega**2 * coupling - 1.3 * np.sin(theta) - 0.7 * omega) / inertia(theta, mass)

    size = 64 * EPS * (1.0 + np.abs(rate).max() + np.abs(omega).max() ** 2)
    assert np.abs(view.drift(0.0, x) - np.concatenate([omega * t, rate * t - omega**2 * r])).max() <= size
    kick = np.sqrt(2 * 0.7 * 0.4) / inertia(theta, mass) * t
    assert np.abs(B[2:] - t[:, None] * kick[None]).max() <= size


def test_what_is_known_depends_on_the_mass() -> None:
    """With unit mass the solution comes from the angle form, and moments are known without gravity; else not."""
    usual, heavy = damped_pendulum(c_g=0.0), damped_pendulum(c_g=0.0, mass=2.0)

    assert "angle form" in usual.pathwise.source
    assert "inherent SDE" in heavy.pathwise.source
    assert {type(truth) for truth in heavy.truths} == {Pathwise, InvariantMean}
    assert heavy.constraint_bound == pytest.approx(2.0 / 0.99**2)


@pytest.mark.parametrize("mass", [0.0, -1.0, float("nan"), float("inf")])
def test_a_mass_that_makes_no_sense_is_refused(mass: float) -> None:
    """Zero, negative, infinite and missing masses are refused in words that show them."""
    with pytest.raises(ParameterError, match="mass must be positive and finite, got"):
        damped_pendulum(mass=mass)


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


def by_operator(problem: object) -> dict[str, str]:
    """Return what the transfer operator of the half-explicit scheme says of each mean that symmetry leaves."""
    result = verify("half-explicit-euler[truncation=none]", [problem], "invariant")
    assert result.details("invariant")["method"].str.contains("operator").all()
    found = result.verdicts[~result.verdicts["quantity"].isin(["r_1", "v_1", "v_2"])]
    return dict(zip(found["quantity"], found["verdict"], strict=True))


MEANS = ("r_2", "r_1^2", "|v|^2", "|v|^4")


@pytest.mark.slow
@pytest.mark.parametrize("problem", ["damped-pendulum", "damped-pendulum[mass=2]", "damped-pendulum[mass=0.6]"])
def test_the_half_explicit_scheme_has_the_invariant_law(problem: str) -> None:
    """The transfer operator verifies order 1 towards every mean, with and without a mass matrix."""
    assert by_operator(problem) == dict.fromkeys(MEANS, "verified")


def without_the_factor() -> HolonomicSDAE:
    """Return the problem with the means of the density exp(-V/kT) by itself, which has no factor sqrt(<t, M t>)."""
    problem = damped_pendulum(mass=2.0)
    wrong = Canonical(lambda x: x[1], np.eye(2), 0.5).means(circle_nodes, 64)
    truths = [
        replace(truth, value=wrong[truth.observable]) if truth.observable in {"r_2", "r_1^2"} else truth
        for truth in problem.truths
        if isinstance(truth, InvariantMean)
    ]
    return replace(problem, truths=tuple(truths))


@pytest.mark.slow
def test_the_law_without_the_factor_of_the_mass_matrix_is_refuted() -> None:
    """Means of positions under arc length are refuted, those of velocities, left right, are verified."""
    expected = {"r_2": "refuted", "r_1^2": "refuted", "|v|^2": "verified", "|v|^4": "verified"}

    assert by_operator(without_the_factor) == expected
