"""The exponential strip: printed means, its closed forms, and the balance that a missing term would break."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from sdaeverify import ConstraintGeometry, InvariantMean, Moment, ParameterError
from sdaeverify.noise.brownian import Source, brownian_steps
from sdaeverify_problems.exponential_strip import exponential_strip

# (q, eps): E t and E |n|^2 for alpha = kappa = sigma = 1, c = 1/2.
PRINTED = {
    (1, 1e-3): (0.50025062506, 5.0049974750e-4),
    (1, 1e-2): (0.50256253722, 5.0497245314e-3),
    (1, 0.1): (0.53101697298, 0.054466124327),
    (1, 1.0): (0.79187250843, 0.39593625422),
    (2, 1e-3): (0.50050175112, 1.0015002423e-3),
    (2, 1e-2): (0.50517605140, 1.0150171144e-2),
    (2, 0.1): (0.56763487269, 0.11425312905),
    (2, 1.0): (1.13896751423, 0.81948375711),
}


def limits(eps: float, q: int = 1, **parameters: float) -> dict[str, float]:
    problem = exponential_strip(eps, q, **parameters)
    return {truth.observable: truth.value for truth in problem.truths if isinstance(truth, InvariantMean)}


@pytest.mark.parametrize(("q", "eps"), PRINTED)
def test_means_are_those_printed(q: int, eps: float) -> None:
    """E t and E |n|^2 agree with the formula sheet to its eleven digits."""
    known = limits(eps, q)
    assert known["t"] == pytest.approx(PRINTED[q, eps][0], abs=6e-12)
    assert known["|n|^2"] == pytest.approx(PRINTED[q, eps][1], rel=1e-10)


@pytest.mark.parametrize("q", [1, 2, 3])
def test_closed_forms_are_those_of_the_constraint(q: int) -> None:
    """Everything that schemes ask for follows from the constraint alone, by complex steps and their differences."""
    problem = exponential_strip(0.1, q, 1.3)
    plain = replace(problem, jacobian=None, second=None, laplacians=None, geometry=ConstraintGeometry)
    x = np.random.default_rng(0).standard_normal((1 + q, 7))
    for name in ("zeta", "share", "relaxation", "quadratic", "fixman", "divergence", "normal_traces"):
        given, expected = getattr(problem.near(x), name), getattr(plain.near(x), name)
        assert np.abs(given - expected).max() <= 1e-10 * (1.0 + np.abs(expected).max()), name


def drift_along(eps: float, alpha: float, fixman: float) -> float:
    """Return the mean of the drift of t under the law of n and at the known E t, a part of Fixman's term left out."""
    problem, sigma = exponential_strip(eps, 1, alpha), 1.0
    power, centre = 0.5 - 1.0 / (sigma**2 * eps * alpha**2), limits(eps, 1, alpha=alpha)["t"]

    def density(n: float) -> float:
        return float(np.exp(-(n**2)) * (1.0 + (alpha * n) ** 2) ** power)

    def drift(n: float) -> float:
        x = np.array([[centre], [n]])
        lacking = (1.0 - fixman) * 0.25 * sigma**2 * problem.near(x).fixman[0, 0]
        return float(problem.ito().drift(0.0, x)[0, 0] - lacking) * density(n)

    end = 12.0 * np.sqrt(eps)
    whole, mass = (quad(f, -end, end, epsabs=1e-13, epsrel=1e-12, limit=200)[0] for f in (drift, density))
    return float(whole / mass)


@pytest.mark.parametrize("alpha", [0.7, 1.0])
@pytest.mark.parametrize("eps", [0.01, 0.1])
def test_the_drift_along_the_strip_balances(eps: float, alpha: float) -> None:
    """The equation's own drift of t has mean 0 in the long run, by adaptive quadrature; not without Fixman's term."""
    assert abs(drift_along(eps, alpha, 1.0)) < 1e-9
    assert abs(drift_along(eps, alpha, 0.0)) == pytest.approx(0.5 * alpha, rel=1e-9)


def test_the_limit_is_an_ornstein_uhlenbeck_process() -> None:
    """Mean and second moment obey m' = -kappa (m - c) and s' = -2 kappa s + 2 kappa c m + 1, from t = 0."""
    problem, t = exponential_strip(0.0, 2, kappa=1.4, c=0.3), 0.6
    known = {truth.observable: truth.value for truth in problem.truths if isinstance(truth, Moment)}
    h = 1e-5
    m, s = known["t"](t), known["t^2"](t)

    assert (known["t"](t + h) - known["t"](t - h)) / (2 * h) == pytest.approx(-1.4 * (m - 0.3), abs=1e-9)
    slope = (known["t^2"](t + h) - known["t^2"](t - h)) / (2 * h)
    assert slope == pytest.approx(-2.8 * s + 2 * 1.4 * 0.3 * m + 1.0, abs=1e-9)
    assert (known["t"](0.0), known["t^2"](0.0)) == (0.0, 0.0)


def test_the_solution_on_a_path_is_the_limit_of_heun_steps() -> None:
    """Along the line, steps of the trapezoidal rule with a predictor approach it at order 1."""
    problem = exponential_strip(0.0)
    truth, levels = problem.pathwise, next(brownian_steps(Source(5, "strip", 0, 400), 2, 0.5, 9))
    assert truth is not None

    def exact(level: int) -> np.ndarray:
        z, rng, h = truth.start(400), np.random.default_rng(1), 0.5 / 2**level
        for n in range(2**level):
            noise = levels[level].increment(n)._replace(xi=rng.standard_normal((1, 400)))
            z = truth.advance(z, n * h, h, noise)
        return truth.parts(0.5, z)["x"]

    def heun(level: int) -> np.ndarray:
        x, h = problem.initial(400), 0.5 / 2**level
        for n in range(2**level):
            kick = np.stack([levels[level].dW[n, 0], np.zeros(400)])
            f = problem.drift(x)
            x = x + 0.5 * h * (f + problem.drift(x + h * f + kick)) + kick
        return x

    z = exact(9)
    coarse, fine = (np.abs(heun(level) - z).mean() for level in (5, 7))
    assert np.log2(coarse / fine) / 2 == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("q", [1, 2])
@pytest.mark.parametrize("eps", [1e-300, 1e300])
def test_extreme_stiffness_has_finite_truths(eps: float, q: int) -> None:
    """Nothing overflows; without penalty E t is c + sigma^2 q alpha/(2 kappa)."""
    known = limits(eps, q)
    assert np.isfinite(list(known.values())).all()
    assert known["t"] == pytest.approx(0.5 if eps < 1.0 else 0.5 + 0.5 * q, rel=1e-12)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"eps": -1.0}, "eps must be finite and not negative, got -1.0"),
        ({"eps": float("nan")}, "eps must be finite and not negative, got nan"),
        ({"q": 0}, "q must be at least 1, got 0"),
        ({"alpha": 0.0}, "alpha must be positive and finite, got 0.0"),
        ({"kappa": -1.0}, "kappa must be positive and finite, got -1.0"),
    ],
)
def test_bad_parameters_are_named(parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message):
        exponential_strip(**parameters)
