"""Operators on symmetric matrices, and those of steps: against closed forms and independent quadrature."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from cells import Rule
from facade import (
    AFFINE,
    B_1,
    B_2,
    A,
    Operator,
    PlatenWeak2,
    StepMoments,
    noncommuting,
    on_symmetric,
    smat,
    step_moments,
    svec,
)
from probe import linear_cells as c
from probe.strong_cells import WithAreas
from sdaeverify import SDE, Array, Increment, Scheme
from sdaeverify.probing import OneStep

EPS = np.finfo(float).eps
SCALAR = c.linear(-2.0, [1.0])


def moments(scheme: Scheme, problem: SDE, h: float) -> StepMoments:
    return step_moments(OneStep(scheme, problem), h)


def square(found: StepMoments) -> float:
    """Return E R^2 of a scalar step."""
    return float(found.operator.homogeneous.dense()[0, 0])


def test_the_matrix_of_an_operator_acts_like_its_sum() -> None:
    """In the coordinates svec, on a random matrix; and lengths are Frobenius norms."""
    rng = np.random.default_rng(1)
    operator = Operator(rng.standard_normal((3, 3, 5)), rng.uniform(size=5))
    G = rng.standard_normal((3, 3))
    P = G @ G.T

    direct = sum(w * X @ P @ X.T for w, X in zip(operator.weights, np.moveaxis(operator.factors, -1, 0), strict=True))
    assert operator(P) == pytest.approx(direct, rel=1e-13)
    assert smat(operator.dense() @ svec(P), 3) == pytest.approx(direct, rel=1e-13)
    assert np.linalg.norm(svec(P)) == pytest.approx(np.linalg.norm(P), rel=4 * EPS)
    assert operator.size == 6


def test_eulers_operator_on_a_system_is_its_kronecker_form() -> None:
    """E R x R = (Id + h A) x (Id + h A) + h B_1 x B_1 + h B_2 x B_2, from three nodes of a simplex."""
    h, step = 0.1, np.eye(2) + 0.1 * A
    found = moments(c.Formula(c.euler), noncommuting(), h)
    expected = np.kron(step, step) + h * (np.kron(B_1, B_1) + np.kron(B_2, B_2))

    assert len(found.operator.weights) == 3
    assert found.operator.homogeneous.dense() == pytest.approx(on_symmetric(expected, 2), abs=16 * EPS)
    assert found.rule_error == 0.0


@pytest.mark.parametrize("degree", [2, 4, 5])
def test_polynomials_of_degree_four_in_the_noise_are_exact_by_five_nodes(degree: int) -> None:
    """E (1 + z^p)^2 = 1 + 2 E z^p + E z^2p for R = 1 + z^p; of a higher degree, two rules have to agree."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return x * (1.0 + noise.dW**degree)

    found = moments(c.Formula(rule), SCALAR, 1.0)
    assert square(found) == pytest.approx(1.0 + 2.0 * norm.moment(degree) + norm.moment(2 * degree), rel=1e-13)
    assert (len(found.operator.weights) == 5) is (degree <= 4)


def test_nothing_is_certain_of_a_step_that_is_not_linear() -> None:
    """A tamed step has no operator for its second moments: none is looked for."""
    found = moments(c.Formula(c.tamed), SCALAR, 0.3)
    assert found.defect > AFFINE
    assert found.rule_error == np.inf


def test_bounded_variables_have_their_own_moments() -> None:
    """With two points dW^2 = h, so that Milstein's step is Euler's; three points keep fourth moments."""
    h = 0.3
    assert square(moments(c.TwoPoint(c.milstein), SCALAR, h)) == pytest.approx((1 - 2 * h) ** 2 + h, rel=8 * EPS)
    found = moments(PlatenWeak2(), noncommuting(), h)
    assert len(found.operator.weights) % 9 == 0
    assert found.rule_error == 0.0


def test_areas_count_with_a_twelfth_of_the_variance() -> None:
    """A step with b x dW + 3 x H has E R^2 = (1 + a h)^2 + b^2 h + 9 h/12."""
    scheme = WithAreas(lambda problem, x, h, noise: c.euler(problem, x, h, noise) + 3.0 * x * noise.H)
    for h in (0.1, 2.0):
        expected = (1 - 2 * h) ** 2 + h + 0.75 * h
        assert square(moments(scheme, SCALAR, h)) == pytest.approx(expected, rel=8 * EPS)


def test_a_kink_at_zero_is_integrated_on_both_sides() -> None:
    """The balanced step, rational in |dW|, against scipy's quadrature on half lines."""
    h = 0.3
    s = np.sqrt(h)

    def both(z: float) -> float:
        sides = [1.0 + (-2.0 * h + sign * s * z) / (1.0 + s * z) for sign in (1.0, -1.0)]
        return float(sum(side**2 for side in sides) * norm.pdf(z))

    expected = quad(both, 0.0, 9.5, epsabs=1e-14, epsrel=1e-14)[0]
    found = moments(c.Formula(c.balanced), SCALAR, h)
    assert square(found) == pytest.approx(expected, rel=1e-13)
    assert found.rule_error < 1e-12


@pytest.mark.parametrize("cut", [True, False], ids=["clipped", "dropped"])
def test_kinks_and_jumps_anywhere_are_found(cut: bool) -> None:
    """Noise clipped at, or dropped beyond, 1.55 standard deviations, against its truncated second moment."""
    h, reach = 0.3, 1.5517557

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        edge = reach * np.sqrt(h)
        dW = np.clip(noise.dW, -edge, edge) if cut else np.where(np.abs(noise.dW) > edge, 0.0, noise.dW)
        return x + h * problem.drift(0.0, x) + x * dW

    inside = 1.0 - 2.0 * norm.sf(reach) - 2.0 * reach * norm.pdf(reach)
    variance = inside + (2.0 * reach**2 * norm.sf(reach) if cut else 0.0)
    # The last panels at a jump are 9.5/2^46 long.
    assert square(moments(c.Formula(rule), SCALAR, h)) == pytest.approx((1 - 2 * h) ** 2 + h * variance, rel=2e-12)


@pytest.mark.parametrize("shift", [0.0, 0.3], ids=["at 0", "elsewhere"])
def test_two_normals_with_kinks_are_known_as_well_as_it_says(shift: float) -> None:
    """Kinks at 0 are integrated on either side; of others, ten times the disagreement of two rules is a bound."""
    h, problem = 0.3, c.linear(-2.0, [0.6, 0.8])
    edge = shift * np.sqrt(h)

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        denominator = 1.0 + np.abs(noise.dW - edge).sum(axis=0)
        return x + (c.euler(problem, x, h, noise) - x) / denominator

    # Midpoints a fiftieth apart, kinks between them, on the grid of the sum.
    x, y = np.meshgrid(*[(np.arange(-450, 450) + 0.5) / 50.0] * 2)
    s = np.sqrt(h)
    R = 1.0 + (-2.0 * h + s * (0.6 * x + 0.8 * y)) / (1.0 + s * (np.abs(x - shift) + np.abs(y - shift)))
    expected = float((norm.pdf(x) * norm.pdf(y) * R**2).sum() / 2500.0)

    found = moments(c.Formula(rule), problem, h)
    error = abs(square(found) - expected)
    # The midpoint rule leaves about 1/2500 of a second derivative, over 24.
    assert error < 10.0 * found.rule_error + 3e-5
    assert found.rule_error < 1e-12 if shift == 0.0 else 1e-5 < found.rule_error < 0.01


def test_many_normals_are_exact_if_the_step_is_affine_in_them_and_unknown_if_not() -> None:
    """Seven noises: Euler's operator is exact from eight nodes; for a kinked step nothing is claimed."""
    rng = np.random.default_rng(2)
    columns = [0.3 * rng.standard_normal((2, 2)) for _ in range(7)]
    problem, h = c.linear(-2.0 * np.eye(2), columns), 0.1
    found = moments(c.Formula(c.euler), problem, h)
    expected = np.kron(0.8 * np.eye(2), 0.8 * np.eye(2)) + h * sum(np.kron(C, C) for C in columns)

    assert found.operator.homogeneous.dense() == pytest.approx(on_symmetric(expected, 2), rel=1e-13, abs=1e-15)
    assert moments(c.Formula(c.balanced), problem, h).rule_error == np.inf


def test_a_pole_of_the_step_in_its_noise_is_found() -> None:
    """1/(1 - b sqrt(h) z) is infinite at z = 34 standard deviations, where every quadrature returns a number."""
    h = (1.0 / 34.0) ** 2
    found = moments(c.Formula(c.implicit_in_noise), SCALAR, h)
    assert found.pole == pytest.approx(34.0, abs=0.2)
    assert found.coarser is found.operator
    assert found.rule_error == np.inf


@pytest.mark.parametrize("rule", [c.milstein, c.balanced])
@pytest.mark.parametrize("h", [1e-3, 0.1, 10.0, 1e3])
def test_steps_without_poles_have_none(rule: Rule, h: float) -> None:
    """Polynomials and |dW| in a denominator have peaks, but none that grow without bound."""
    assert moments(c.Formula(rule), SCALAR, h).pole == np.inf
