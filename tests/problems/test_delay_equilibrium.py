"""The long run of linear delay equations whose rates times delays overflow an exponential."""

import numpy as np
import pytest

from facade import LinearDelay, ScalarDelay, delay_linear, delay_ou
from facade import _equilibrium as equilibrium
from sdaeverify import InvariantMean, MeanSquareStability


def equation(A: float, B: float, tau: float) -> ScalarDelay:
    return ScalarDelay(A, B, 0.5, 0.5, 0.0, tau, 1.0, 0.0)


@pytest.mark.parametrize("parameters", [{"A": -800.0}, {"tau": 400.0}, {"A": -1e5, "B": -9e4, "tau": 30.0}])
def test_a_truth_of_stability_survives_where_the_exponential_overflows(parameters: dict[str, float]) -> None:
    """By Hayes' criterion r decays for |B| < -A whatever tau is, and little noise leaves E x^2 stable."""
    (truth,) = (truth for truth in delay_linear(**parameters).truths if isinstance(truth, MeanSquareStability))
    assert truth.stable


def test_the_sign_of_the_rate_is_hayes_criterion() -> None:
    """On random rates up to 1e5 and delays up to 1e3, both with one answer and the other."""
    rng, answers = np.random.default_rng(3), set()
    sizes = 10.0 ** rng.uniform(-2.0, [5.0, 5.0, 3.0], (300, 3))
    for A, B, tau in sizes * rng.choice([-1.0, 1.0], (300, 3), p=[0.7, 0.3]) * [1.0, 1.0, 0.0] + sizes * [
        0.0,
        0.0,
        1.0,
    ]:
        decays = A + B < 0.0 and (A <= B or tau * np.sqrt(B * B - A * A) < np.arccos(-A / B))
        assert (equilibrium.rate(equation(A, B, tau)) < 0.0) == decays
        assert LinearDelay(A, B, 0.0, 0.0, tau).mean_decays == decays
        answers.add(decays)
    assert answers == {True, False}


def decays(A: np.ndarray, B: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Return Hayes' criterion for s = A + B e^(-s tau)."""
    turned = tau * np.sqrt(np.maximum(B * B - A * A, 0.0))
    oscillating = turned < np.arccos(np.clip(-A / np.where(B == 0.0, 1.0, B), -1.0, 1.0))
    return np.asarray((A + B < 0.0) & ((A <= B) | oscillating))


def test_no_law_is_declared_where_two_real_roots_are_positive_or_one_is() -> None:
    """Of s = .6 - .5466 e^-s and s = 2 - 1.822 e^(-.3 s) the larger real root is positive."""
    assert not [truth for truth in delay_ou(A=0.6, B=-0.5466).truths if isinstance(truth, InvariantMean)]
    problem = delay_linear(A=2.0, B=-1.822, c=0.0, d=0.1, tau=0.3)
    assert [truth.stable for truth in problem.truths if isinstance(truth, MeanSquareStability)] == [False]


@pytest.mark.parametrize(("A", "B"), [(-800.0, -1.0), (-800.0, 700.0), (-900.0, -850.0)])
def test_the_stationary_variance_is_the_integral_of_the_spectrum(A: float, B: float) -> None:
    """sigma^2 times the integral of 1/(2 pi |i w - A - B e^(-i w tau)|^2) over all frequencies."""
    sigma, step, end = 0.7, 0.02, 4e4
    truths = delay_ou(A, B, sigma).truths
    known = {truth.observable: truth.value for truth in truths if isinstance(truth, InvariantMean)}
    w = np.arange(0.5 * step, end, step)
    density = 1.0 / np.abs(1j * w - A - B * np.exp(-1j * w)) ** 2
    # Beyond the end, 1/w^2 up to (A/w)^2 of it.
    assert known["x^2"] == pytest.approx(sigma**2 / np.pi * (step * density.sum() + 1.0 / end), rel=1e-5)
    assert (known["x"], known["x^3"]) == (0.0, 0.0)
