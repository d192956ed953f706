"""Closed curves: printed means, and quadrature over the arc length with another inverse."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from sdaeverify import ConstrainedLangevin, InvariantMean, Moment, ParameterError
from sdaeverify.arrays import Array
from sdaeverify_problems._curve_shapes import SHAPES
from sdaeverify_problems.constrained_curve import OBSERVABLES, constrained_curve

# sigma = 0.8, T = 1.
PRINTED = {
    ("ellipse", np.pi / 3): {"x_1": 0.93983231, "x_2": 0.75257412, "x_1^2": 1.36695308},
    ("space", 0.4): {"x_1": 0.70399762, "x_2": 0.31706535},
}


def moments(problem: ConstrainedLangevin, t: float) -> dict[str, float]:
    return {truth.observable: truth.value(t) for truth in problem.truths if isinstance(truth, Moment)}


@pytest.mark.parametrize(("shape", "theta"), PRINTED)
def test_means_are_those_printed(shape: str, theta: float) -> None:
    """Expectations at t = 1 agree with the formula sheet to its eight digits."""
    known = moments(constrained_curve(0.0, shape, 0.8, theta), 1.0)
    for name, value in PRINTED[shape, theta].items():
        assert known[name] == pytest.approx(value, abs=6e-9)


def speed(shape: str, theta: float) -> float:
    if shape == "ellipse":
        return float(np.hypot(2.0 * np.sin(theta), np.cos(theta)))
    return float(np.hypot(1.0, 0.7 * np.cos(2.0 * theta)))


def moved(shape: str, theta: float, s: float) -> float:
    """Return the parameter at arc length s from another one, by adaptive quadrature and bisection."""
    return float(brentq(lambda y: quad(lambda x: speed(shape, x), theta, y)[0] - s, theta - 9.0, theta + 9.0))


@pytest.mark.parametrize("shape", SHAPES)
def test_moments_are_those_of_a_normal_arc_length(shape: str) -> None:
    """E phi(X_t) is the mean of phi over s_0 + sigma sqrt(t) N, by Gauss-Hermite quadrature with 24 nodes."""
    theta, sigma, t = 1.0, 0.8, 0.2
    nodes, weights = np.polynomial.hermite_e.hermegauss(24)
    angles = np.array([moved(shape, theta, sigma * np.sqrt(t) * n) for n in nodes])
    x: Array = SHAPES[shape].gamma(angles[None])
    known = moments(constrained_curve(0.0, shape, sigma, theta), t)
    for name, phi in OBSERVABLES.items():
        assert known[name] == pytest.approx(weights @ phi(x) / np.sqrt(2.0 * np.pi), abs=1e-6)


@pytest.mark.parametrize("shape", SHAPES)
def test_moments_tend_to_the_means_by_arc_length(shape: str) -> None:
    """After thirty relaxation times nothing is left of the start."""
    problem = constrained_curve(0.0, shape)
    late = moments(problem, 30.0 * problem.relaxation)
    for truth in problem.truths:
        if isinstance(truth, InvariantMean):
            assert truth.value == pytest.approx(late[truth.observable], abs=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_curve_is_where_the_constraint_vanishes(shape: str) -> None:
    """Points of every parameter keep the constraint to rounding."""
    x = SHAPES[shape].gamma(np.linspace(-3.0, 3.0, 50)[None])
    assert np.abs(constrained_curve(0.0, shape).constraint(x)).max() < 1e-15


def test_nothing_is_promised_off_the_curve() -> None:
    """With a penalty there are neither truths nor a chart."""
    problem = constrained_curve(0.1)
    assert (problem.truths, problem.chart) == ((), None)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"shape": "knot"}, "shape must be one of ellipse, space, got 'knot'"),
        ({"eps": float("nan")}, "eps must be finite and not negative, got nan"),
        ({"sigma": -1.0}, "sigma must be positive and finite, got -1.0"),
    ],
)
def test_bad_parameters_are_named(parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message):
        constrained_curve(**parameters)
