"""Spectral radii of positive operators and the certificates of their errors."""

import numpy as np
import pytest

from facade import Operator, are_below, spectral, spectral_radius, step_moments
from probe import linear_cells as c
from sdaeverify import Array
from sdaeverify.probing import OneStep


def operator(*factors: Array) -> Operator:
    """Return P -> sum_k A_k P A_k^T."""
    return Operator(np.stack([np.asarray(X, dtype=float) for X in factors], axis=-1), np.ones(len(factors)))


def delayed(steps: int, strength: float, b: float) -> Operator:
    """Return the operator of a delay equation whose scheme keeps so many past states, h = 1/20."""
    one_step = OneStep(c.Delayed(steps, strength), c.linear(-2.0, [b]))
    return step_moments(one_step, 0.05).operator.homogeneous


KNOWN = {
    "one matrix": (operator([[0.9, 1.0], [0.0, 0.5]]), 0.81),
    "a rotation": (operator(0.8 * np.array([[0.6, -0.8], [0.8, 0.6]])), 0.64),
    "decoupled": (operator(np.diag([0.9, 0.1, 0.2])), 0.81),
    "an algebraic component": (operator([[0.9, 0.0], [2.0, 0.0]], [[0.1, 0.0], [-5.0, 0.0]]), 0.82),
    "nilpotent": (operator([[0.0, 1.0], [0.0, 0.0]]), 0.0),
    "large": (operator(np.diag([1e3, 1.0])), 1e6),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_radii_are_found_with_tight_certificates(name: str) -> None:
    """Decoupled, algebraic and nilpotent parts included, on which the Collatz-Wielandt brackets do not close."""
    T, rho = KNOWN[name]
    found = spectral_radius(T)
    assert abs(found.rho - rho) <= found.width <= 1e-11 * max(1.0, rho)


def test_defective_eigenvalues_are_known_as_far_as_their_certificate_says() -> None:
    """A threefold eigenvalue in one Jordan block is found to the cube root of rounding only, and this is said."""
    found = spectral_radius(operator([[0.9, 1.0], [0.0, 0.9]]))
    assert abs(found.rho - 0.81) <= found.width
    assert 1e-7 < found.width < 1e-4


def test_a_wrong_radius_has_no_tight_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the eigenvalues were off by 1e-6, the width would be that."""
    T, _ = KNOWN["one matrix"]
    monkeypatch.setattr(spectral.np.linalg, "eigvals", lambda matrix: np.array([0.81 + 1e-6]))
    assert 1e-6 <= spectral_radius(T).width <= 1e-5


@pytest.mark.parametrize(("strength", "b"), [(-0.5, 0.5), (-1.5, 0.3)])
def test_large_operators_have_brackets_by_their_values(
    strength: float, b: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Arnoldi's method on a delay equation with 13 states, against the certificates of its matrix."""
    monkeypatch.setattr(spectral, "DENSE", 50)
    T = delayed(12, strength, b)
    assert T.size > spectral.DENSE
    found, matrix = spectral_radius(T), T.dense()
    assert found.width < 1e-10
    assert are_below(T, matrix, found.rho + found.width + 1e-12) == [True]
    assert are_below(T, matrix, found.rho - found.width - 1e-12) == [False]


def test_an_eigenvalue_that_is_not_the_largest_is_unmasked(monkeypatch: pytest.MonkeyPatch) -> None:
    """With too few vectors Arnoldi's method settles on a complex pair, whose matrix is no certificate."""
    T = delayed(30, -1.5, 0.3)
    assert spectral_radius(T).width < 1e-10
    monkeypatch.setattr(spectral, "VECTORS", 20)
    found = spectral_radius(T)
    assert are_below(T, T.dense(), found.rho + 1e-4) == [False]
    assert found.width == np.inf


def test_what_overflows_is_infinite() -> None:
    """Neither a factor nor a product of factors that is too large stops anything."""
    with np.errstate(over="ignore"):
        for size in (1e200, np.inf):
            assert spectral_radius(operator([[size]])).rho == np.inf


def test_one_factor_of_many_rows_is_as_certain_as_any():
    """With factors that differ by rounding the radius is that of one of them, and as the whole matrix has it."""
    rng = np.random.default_rng(5)
    A = rng.standard_normal((8, 8)) / 4.0
    alike = Operator(np.stack([A, A * (1.0 + 1e-15), A * (1.0 - 1e-15)], axis=-1), np.array([0.5, 0.25, 0.25]))
    found = spectral_radius(alike)
    assert found.rho == pytest.approx(np.abs(np.linalg.eigvals(alike.dense())).max(), rel=1e-12)
    assert found.width <= 1e-10
    apart = Operator(np.stack([A, 0.5 * A], axis=-1), np.array([0.5, 0.5]))
    assert spectral_radius(apart).rho == pytest.approx(np.abs(np.linalg.eigvals(apart.dense())).max(), rel=1e-12)
