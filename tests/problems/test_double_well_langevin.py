"""Langevin dynamics in a double well: its invariant law by quadrature of its force, and its relaxation time."""

import numpy as np
import pytest

from facade import double_well_langevin
from sdaeverify import InvariantMean, ParameterError


def means_of(problem):
    """Return the invariant means that a problem states."""
    return {truth.observable: truth.value for truth in problem.truths if isinstance(truth, InvariantMean)}


def force_of(problem, q):
    """Return the force at a position."""
    return float(problem.force(np.full((1, 1), q))[0, 0])


@pytest.mark.parametrize(("m", "kT"), [(1.0, 0.5), (0.3, 0.5), (1.5, 0.8)])
def test_invariant_means_are_those_of_the_force(m, kT):
    """The density exp(-V/kT), with V integrated from the force, has the stated means."""
    problem = double_well_langevin(m=m, kT=kT)
    end = m + 9.0 * np.sqrt(kT)
    grid = np.linspace(0.0, end, 4001)
    forces = np.broadcast_to(problem.force(grid[None]), (1, grid.size))[0]
    # Simpson's rule on pairs of intervals; the force varies on a scale of 1, so that its error is about h^4 = 1e-9.
    h = grid[2] - grid[0]
    potential = -np.concatenate([[0.0], np.cumsum(h / 6.0 * (forces[:-2:2] + 4.0 * forces[1::2] + forces[2::2]))])
    weights = np.exp(-potential / kT)
    weights[0] *= 0.5  # the density is even
    mean = {
        name: float(weights @ f(grid[::2]) / weights.sum()) for name, f in {"q^2": np.square, "cos q": np.cos}.items()
    }

    stated = means_of(problem)
    assert {name: stated[name] for name in mean} == pytest.approx(mean, rel=1e-7)
    assert problem.strength**2 / (2.0 * problem.friction) == pytest.approx(stated["p^2"], rel=1e-14)
    assert [stated[name] for name in ("q", "q p")] == [0.0, 0.0]


def test_law_is_not_normal():
    """By default the law has two maxima, and cos q a mean that no normal law of the same variance has."""
    problem, stated = double_well_langevin(), means_of(double_well_langevin())

    assert force_of(problem, 0.1) > 0.0 > force_of(problem, 2.0)
    assert abs(stated["cos q"] - np.exp(-0.5 * stated["q^2"])) > 0.05


def gap(gamma, steep, kT=0.5, polynomials=26, hermite=18):
    """Return the gap of the generator by Galerkin's method, polynomials in q times Hermite polynomials in p."""
    problem = double_well_langevin(m=np.sqrt(steep * kT), gamma=gamma, kT=kT)
    end = np.sqrt(steep * kT) + np.sqrt(76.0 * kT)
    q = np.linspace(-end, end, 2001)
    weights = np.exp(-0.5 * q**2 / kT) * np.cosh(np.sqrt(steep / kT) * q)
    values = np.polynomial.chebyshev.chebvander(q / end, polynomials - 1)
    triangular = np.linalg.qr(values * np.sqrt(weights)[:, None], mode="r")
    basis = np.linalg.solve(triangular.T, values.T)
    slopes = np.polynomial.chebyshev.chebder(np.eye(polynomials)) / end
    derived = np.linalg.solve(triangular.T, np.polynomial.chebyshev.chebval(q / end, slopes))
    lower = np.diag(np.sqrt(np.arange(1.0, hermite)), 1)
    drawn = (basis * weights * problem.force(q[None])[0]) @ basis.T
    moved = np.kron((basis * weights) @ derived.T, np.sqrt(kT) * (lower + lower.T))
    rates = -np.linalg.eigvals(
        moved
        + np.kron(drawn, lower / np.sqrt(kT))
        - gamma * np.kron(np.eye(polynomials), np.diag(np.arange(float(hermite))))
    ).real
    return float(rates[rates > 1e-6].min())


@pytest.mark.sweep
@pytest.mark.parametrize("gamma", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("steep", [0.5, 2.0, 3.0])
def test_relaxation_is_estimated_to_its_size(gamma, steep):
    """The estimate is 0.7 to 3 times the reciprocal of the gap of the generator."""
    problem = double_well_langevin(m=np.sqrt(0.5 * steep), gamma=gamma)

    assert 0.7 <= problem.relaxation_time * gap(gamma, steep) <= 3.0


@pytest.mark.parametrize(
    ("given", "told"),
    [({"m": 2.0}, r"m\^2/kT must be at most 3, got 8"), ({"kT": 0.0}, "kT"), ({"gamma": -1.0}, "gamma")],
)
def test_parameters_without_a_law_are_refused(given, told):
    """A deep well, no temperature and no friction are one line."""
    with pytest.raises(ParameterError, match=told):
        double_well_langevin(**given)
