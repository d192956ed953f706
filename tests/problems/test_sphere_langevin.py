"""The heavy point on the sphere: its expectations, its relaxation time, and that a scheme finds its law."""

from dataclasses import replace

import numpy as np
import pytest

from problems.generator import generator, observed
from problems.tangent_law import canonical_nodes, images, monomials, value
from sdaeverify import HolonomicSDAE, InvariantMean, Moment, ParameterError, verify
from sdaeverify.arrays import Array
from sdaeverify_problems._canonical_law import Canonical, sphere_nodes
from sdaeverify_problems.sphere_langevin import sphere_langevin

EPS = np.finfo(float).eps


def expectations(problem: HolonomicSDAE) -> dict[str, Moment]:
    return {truth.observable: truth for truth in problem.truths if isinstance(truth, Moment)}


def states(problem: HolonomicSDAE) -> Array:
    """Return the initial state and random ones on the manifold, shape (7, P)."""
    start = np.concatenate(problem.initial(1))
    return np.concatenate([start, problem.admissible(np.random.default_rng(5).standard_normal((7, 30)))], axis=1)


def fitted(problem: HolonomicSDAE, name: str) -> tuple[float, float, float]:
    """Return slope and source of L q = slope q + source, fitted over states, and what the fit leaves."""
    q, x = observed(problem, name), states(problem)
    values, image = q(x), generator(problem, q, x)
    slope, source = np.polyfit(values, image, 1)
    return float(slope), float(source), float(np.abs(image - slope * values - source).max())


CASES = {
    "heavy": {},
    "heavy, another mass": {"m_1": 2.0, "m_2": 2.0, "m_3": 2.0, "gamma": 0.7},
    "heavy, another mass downwards": {"m_3": 3.0},
    "weightless": {"c_g": 0.0, "kT": 0.4},
    "weightless, another mass": {"c_g": 0.0, "m_1": 3.0, "m_2": 3.0, "m_3": 3.0, "gamma": 2.0},
}


@pytest.mark.parametrize("name", CASES)
def test_expectations_solve_their_equations(name: str) -> None:
    """The generator maps an observable to -rate q + source, and its expectation starts at q and solves that."""
    problem, known = sphere_langevin(**CASES[name]), expectations(sphere_langevin(**CASES[name]))
    assert set(known) == {"(r x v)_3", *(("(r x v)_1", "|v|^2", "v^T M v") if "weightless" in name else ())}
    for observable, moment in known.items():
        slope, source, rest = fitted(problem, observable)
        start, limit = observed(problem, observable)(states(problem)[:, :1])[0], -source / slope
        assert rest <= 1e-8
        for t in (0.0, 0.4, 2.0):
            exact = limit + (start - limit) * np.exp(slope * t)
            assert moment.value(t) == pytest.approx(exact, abs=1e-8), (observable, t)


def test_masses_that_differ_have_no_such_expectations() -> None:
    """With different masses r x v and |v|^2 obey no equation of their own, which the fit would notice."""
    problem = sphere_langevin(c_g=0.0, m_2=1.5)

    assert not expectations(problem)
    assert fitted(problem, "(r x v)_3")[2] > 1e-2
    assert fitted(problem, "|v|^2")[2] > 1e-2


def gap(problem: HolonomicSDAE, mass: Array, kT: float, c_g: float) -> float:
    """Return the least positive eigenvalue of -L among polynomials of degrees up to 3, by Galerkin's method."""
    law, exponents = canonical_nodes(mass, kT, lambda r: c_g * r[2], count=12), monomials(3, 3)
    basis = np.stack([value(e, law.x) for e in exponents])
    basis_norm = np.sqrt((basis**2) @ law.weights)[:, None]
    weighted = basis / basis_norm * law.weights
    gram, L = weighted @ (basis / basis_norm).T, weighted @ (images(problem, law.x, exponents).values / basis_norm).T
    # On the sphere and on its tangent planes the monomials are not independent.
    sizes, directions = np.linalg.eigh(gram)
    kept = sizes > 1e-9 * sizes[-1]
    reduced = directions[:, kept] / np.sqrt(sizes[kept])
    rates = np.sort(-np.linalg.eigvals(reduced.T @ L @ reduced).real)
    return float(rates[rates > 1e-5][0])


@pytest.mark.slow
@pytest.mark.parametrize("masses", [(1.0, 1.0, 1.0), (1.0, 2.0, 4.0), (1.0, 8.0, 1.0)])
@pytest.mark.parametrize(("c_g", "kT"), [(1.0, 0.1), (1.0, 0.5), (0.0, 0.5)])
@pytest.mark.parametrize("gamma", [0.3, 1.0, 3.0])
def test_relaxation_is_estimated_to_its_size(
    masses: tuple[float, float, float], c_g: float, kT: float, gamma: float
) -> None:
    """The estimate is between 1 and 5 times the reciprocal of the generator's gap."""
    problem = sphere_langevin(c_g, gamma, kT, *masses)

    assert 1.0 <= problem.relaxation * gap(problem, np.diag(masses), kT, c_g) <= 5.0


@pytest.mark.parametrize("masses", [(0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, float("inf"))])
def test_masses_that_make_no_sense_are_refused(masses: tuple[float, float, float]) -> None:
    """Zero, negative and infinite masses are refused in words that show them."""
    with pytest.raises(ParameterError, match="masses must be positive and finite, got"):
        sphere_langevin(1.0, 1.0, 0.1, *masses)


WARM = {"c_g": 1.5, "gamma": 2.0, "kT": 0.3, "m_1": 1.0, "m_2": 2.0, "m_3": 4.0}
INFORMATIVE = ("r_3", "r_1^2", "r_3^2", "|v|^2", "v^T M v")


def by_chains(problem: object) -> dict[str, str]:
    """Return what paired chains of the half-explicit scheme say of each mean that no symmetry makes zero."""
    result = verify("half-explicit-euler[truncation=none]", [problem], "invariant")
    assert result.details("invariant")["method"].str.contains("chains").all()
    found = result.verdicts[result.verdicts["quantity"].isin(INFORMATIVE)]
    return dict(zip(found["quantity"], found["verdict"], strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("parameters", [{}, WARM], ids=["unit mass", "masses 1, 2, 4"])
def test_the_half_explicit_scheme_samples_the_invariant_law(parameters: dict[str, float]) -> None:
    """Paired chains verify order 1 towards every mean, with and without a mass matrix."""
    given = ",".join(f"{name}={value}" for name, value in parameters.items())
    found = by_chains(f"sphere-langevin[{given}]" if given else "sphere-langevin")

    assert found == dict.fromkeys(INFORMATIVE, "verified")


def without_the_factor() -> HolonomicSDAE:
    """Return the problem with the means of the density exp(-V/kT) by itself."""
    problem, kT = sphere_langevin(**WARM), WARM["kT"]
    wrong = Canonical(lambda x: WARM["c_g"] * x[2], np.eye(3), kT).means(sphere_nodes, 64)
    truths = [
        replace(truth, value=wrong[truth.observable])
        if isinstance(truth, InvariantMean) and truth.observable in {"r_3", "r_1^2", "r_3^2"}
        else truth
        for truth in problem.truths
    ]
    return replace(problem, truths=tuple(truths))


@pytest.mark.slow
def test_the_law_without_the_factor_of_the_mass_matrix_is_refuted() -> None:
    """Means of positions under the ordinary surface measure are refuted, those of velocities, left right, are not."""
    found = by_chains(without_the_factor)

    assert {found[name] for name in ("r_3", "r_1^2", "r_3^2")} == {"refuted"}
    assert "refuted" not in {found[name] for name in ("|v|^2", "v^T M v")}
