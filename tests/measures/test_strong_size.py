"""The constant of the leading strong error is that of the equation of the asymptotic error."""

from typing import Any

import numpy as np
import pytest

from sdaeverify import verify

RUN: dict[str, Any] = {"levels": "8..64", "progress": "none", "seed": 3}


def constants(scheme, problem, **run):
    """Return the details of strong errors by quantity."""
    found = verify(scheme, problem, "strong", **{"paths": 256, **RUN, **run})
    return {row["quantity"]: row for _, row in found.details("strong").iterrows()}, found


def test_euler_maruyama_on_geometric_brownian_motion():
    """Kurtz and Protter 1991: the error is h^(1/2) U, U_T = X_T (b^2/sqrt(2)) V_T for an independent motion V."""
    details, _ = constants("euler-maruyama", "gbm")
    a, b = 0.5, 0.6
    wanted = np.sqrt(0.5 * b**4 * np.exp(2.0 * a + b**2))

    assert details["x@T"]["error_power"] == 0.5
    assert abs(details["x@T"]["error_constant"] - wanted) <= details["x@T"]["error_constant_known"] < 1e-3 * wanted
    # The largest error on a grid has no constant.
    assert np.isnan(details["x"]["error_constant"])


def test_additive_euler_maruyama():
    """On dx = -a x dt + s dW the error is h U, dU = -a U dt - (a^2/2) x dt + (a s/2) dW + (a s/sqrt(12)) dV.

    V is an independent motion: a step is off by -(a^2/2) h^2 x + a s int (t + h - u) dW_u to leading order.
    """
    details, found = constants("euler-maruyama", "ou")
    problem = found.results[0].cell.spec.build()
    x0, T = float(problem.initial(1)[0, 0]), problem.horizon
    zero, one = np.zeros((1, 1)), np.ones((1, 1))
    a = float((problem.drift(0.0, zero) - problem.drift(0.0, one))[0, 0])
    s = float(problem.diffusion(0.0, one)[0, 0, 0])
    # U_T = -(a^2/2) T e^(-a T) x_0 + int e^(-a v) ((a s/2) (1 - a v) dW + (a s/sqrt(12)) dV), v = T - u.
    v = np.linspace(0.0, T, 20001)
    noise = np.trapezoid(a**2 * s**2 * np.exp(-2.0 * a * v) * ((1.0 - a * v) ** 2 / 4.0 + 1.0 / 12.0), v)
    wanted = np.sqrt((0.5 * a**2 * T * np.exp(-a * T) * x0) ** 2 + noise)

    assert problem.drift(0.0, zero)[0, 0] == 0.0
    assert details["x@T"]["error_power"] == 1.0
    assert details["x@T"]["error_constant"] == pytest.approx(wanted, rel=1e-4)


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("scheme", "problem", "quantity"), [("sri1w1", "spiral", "x@T"), ("baoab", "harmonic-langevin", "p@T")]
)
def test_paths_have_the_same_errors(scheme, problem, quantity):
    """Root mean squares of 4096 paths at the finest level are within 10 per cent, some five standard errors."""
    details, found = constants(scheme, problem, paths=4096, max_looks=1)
    levels = found.levels[found.levels["quantity"] == quantity].sort_values("h")
    row, finest = details[quantity], levels.iloc[0]

    assert finest["paths"] == 4096
    assert finest["estimate_L2"] == pytest.approx(row["error_constant"] * finest["h"] ** row["error_power"], rel=0.1)


def test_a_step_that_is_no_polynomial_of_its_noise_has_none():
    """Nothing is said of the balanced scheme, whose step has |dW|."""
    details, _ = constants("balanced-euler", "gbm")

    assert "error_constant" not in details["x@T"] or np.isnan(details["x@T"]["error_constant"])
