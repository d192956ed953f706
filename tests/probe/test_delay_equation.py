"""Mean-square stability of the linear delay equation against series, collocation and the issue's numbers."""

from math import factorial

import numpy as np
import pytest

from facade import LinearDelay
from probe.theta_cells import SETS

EPS = float(np.finfo(float).eps)
EQUATIONS = [
    LinearDelay(-2.0, 1.0, 0.6, -0.3, 1.0),
    LinearDelay(-2.0, -1.0, 0.6, 0.3, 1.0),
    LinearDelay(-1.0, -1.3, 0.6, 0.3, 1.0),
    LinearDelay(0.2, -0.6, 0.6, 0.3, 1.0),
    LinearDelay(-1.0, -1.0, 0.6, 0.3, 1.0),
    LinearDelay(-1.0, -1.0 - 1e-9, 0.6, 0.3, 1.0),
    LinearDelay(-1.0, -1.0 + 1e-9, 0.6, 0.3, 1.0),
    LinearDelay(-2.0, 0.0, 0.6, 0.3, 1.0),
    LinearDelay(-2.0, 1.0, 0.6, 0.3, 0.25),
]


def response(equation: LinearDelay, t: np.ndarray) -> np.ndarray:
    """Return the fundamental solution: the sum of B^k (t - k tau)^k e^(A (t - k tau))/k! over k tau <= t."""
    A, B, _, _, tau = equation
    ages = [(k, t - k * tau) for k in range(int(t.max() / tau) + 1)]
    terms = (np.where(s >= 0.0, (B * np.maximum(s, 0.0)) ** k * np.exp(A * s) / factorial(k), 0.0) for k, s in ages)
    return np.asarray(sum(terms))


def integrated(equation: LinearDelay, delays: int) -> float:
    """Return the integral of (c r(t) + d r(t - tau))^2 by Gauss' rule between the kinks."""
    q, w = np.polynomial.legendre.leggauss(40)
    t = equation.tau * (np.arange(delays)[:, None] + 0.5 * (q + 1.0)).ravel()
    past = np.where(t >= equation.tau, response(equation, np.maximum(t - equation.tau, 0.0)), 0.0)
    values = (equation.c * response(equation, t) + equation.d * past) ** 2
    return float(values @ np.tile(0.5 * equation.tau * w, delays))


def collocated(equation: LinearDelay, nodes: int = 24) -> float:
    """Return the largest real part of the eigenvalues of the delay operator on Chebyshev polynomials."""
    j = np.arange(nodes + 1)
    x = np.cos(np.pi * j / nodes)
    c = np.where((j == 0) | (j == nodes), 2.0, 1.0) * (-1.0) ** j
    D = np.outer(c, 1.0 / c) / (x[:, None] - x + np.eye(nodes + 1))
    D -= np.diag(D.sum(axis=1))
    D *= 2.0 / equation.tau
    # The first node is the present, the last is one delay ago.
    D[0] = 0.0
    D[0, 0], D[0, -1] = equation.A, equation.B
    return float(np.linalg.eigvals(D).real.max())


@pytest.mark.parametrize("equation", EQUATIONS)
def test_the_integral_of_the_noise_is_that_of_the_fundamental_solution(equation: LinearDelay) -> None:
    """Oscillating, monotone and limiting equations, against the series of the fundamental solution."""
    delays = 40 if equation.tau == 1.0 else 120
    # What is left out decays like the rightmost root.
    left_out = np.exp(2.0 * equation.rightmost_root.real * delays * equation.tau)
    assert equation.noise_integral == pytest.approx(integrated(equation, delays), rel=1e-9, abs=10.0 * left_out)


def test_long_delays_do_not_overflow() -> None:
    """As tau grows, K(0) tends to 1/(2 w) and K(tau) to beta/(2 w) with beta = B/(w - A)."""
    w = np.sqrt(3.0)
    assert LinearDelay(-2.0, 1.0, 0.0, 0.0, 1e5).covariances == pytest.approx((0.5 / w, 0.5 / (w * (w + 2.0))))


@pytest.mark.parametrize("equation", [*EQUATIONS, *(each.equation for each in SETS.values())])
def test_the_rightmost_root_is_that_of_the_delay_operator(equation: LinearDelay) -> None:
    """Against the eigenvalues of Chebyshev collocation; a double root is known to half the digits."""
    root = equation.rightmost_root
    assert root.real == pytest.approx(collocated(equation), abs=1e-9)
    assert abs(root - equation.A - equation.B * np.exp(-root * equation.tau)) < 100.0 * EPS * (1.0 + abs(equation.A))


@pytest.mark.parametrize("B", [3.0, -3.0])
def test_roots_where_the_argument_of_lamberts_function_overflows(B: float) -> None:
    """With A tau = -10^4 the root is still one: B e^(-s tau) = s - A, whose rounding is that of e^(-s tau)."""
    s = LinearDelay(-1000.0, B, 0.0, 0.0, 10.0).rightmost_root
    assert abs(B * np.exp(-10.0 * s) / (s + 1000.0) - 1.0) < 100.0 * EPS * 1e4


@pytest.mark.parametrize(
    ("name", "rate", "digit"),
    [("I", -1.0, 1e-12), ("II", 0.8049, 1e-4), ("III", -2.71, 1e-2), ("IV", -1.86, 1e-2), ("V", 0.72, 1e-2),
     ("VI", -1.10, 1e-2)],
)  # fmt: skip
def test_growth_rates_of_the_six_sets(name: str, rate: float, digit: float) -> None:
    """Without the sine they are the published ones, to their last digit; the verdict is their sign."""
    equation = SETS[name]._replace(l=0.0).equation
    assert equation.growth_rate == pytest.approx(rate, abs=0.5 * digit)
    assert equation.stable is (rate < 0.0)


@pytest.mark.parametrize("equation", EQUATIONS)
def test_an_equation_slowed_by_its_growth_rate_is_on_the_boundary(equation: LinearDelay) -> None:
    """Slowed by a little less it grows, by a little more it decays."""
    rate = equation.growth_rate
    assert equation.discount(rate - 1e-9).stable is False
    assert equation.discount(rate + 1e-9).stable is True


@pytest.mark.parametrize(("A", "B"), [(-2.0, 0.0), (-2.0, 0.5)])
def test_growth_without_delay(A: float, B: float) -> None:
    """E x^2 grows at the rate 2 (A + B) + (c + d)^2."""
    assert LinearDelay(A, B, 0.7, 0.4, 0.0).growth_rate == pytest.approx(2.0 * (A + B) + 1.1**2, abs=1e-12)


def test_growth_of_what_noise_does_not_excite() -> None:
    """With c + d e^(-s tau) = 0 at the rightmost root s, and without noise, the rate is 2 s."""
    quiet = LinearDelay(-2.0, 1.0, 0.0, 0.0, 1.0)
    s = quiet.rightmost_root.real
    assert quiet.growth_rate == pytest.approx(2.0 * s, abs=1e-12)
    hidden = quiet._replace(c=0.1, d=-0.1 * np.exp(s))
    assert hidden.growth_rate == pytest.approx(2.0 * s, abs=1e-9)
    assert hidden._replace(d=-0.12 * np.exp(s)).growth_rate > 2.0 * s + 1e-5


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_boundary_in_d_is_the_published_one(sign: float) -> None:
    """A = -2, B = 1, c = 0, tau = 1: |d*| = 1.7749729938, to its last digit; a billionth decides."""
    boundary = sign * 1.7749729938
    inside, outside = (LinearDelay(-2.0, 1.0, 0.0, boundary * part, 1.0) for part in (1.0 - 1e-9, 1.0 + 1e-9))

    assert inside.stable is True
    assert outside.stable is False


def test_means_decay_where_the_rightmost_root_says_so() -> None:
    """On random coefficients, in all four quadrants, with delays shorter and longer than their time scale."""
    rng = np.random.default_rng(0)
    seen = set()
    for A, B in 3.0 * rng.standard_normal((60, 2)):
        equation = LinearDelay(A, B, 0.0, 0.0, rng.exponential(1.0))
        assert equation.mean_decays is bool(equation.rightmost_root.real < 0.0)
        seen.add((A < 0.0, B < A, equation.mean_decays))
    assert {(True, True, True), (True, True, False), (True, False, True), (False, True, True)} <= seen


def test_means_at_the_boundary_decide_nothing() -> None:
    """A = 0, B tau = -pi/2 has roots on the axis; a billionth beside, and at A + B = 0, all is certain."""
    edge = LinearDelay(0.0, -0.5 * np.pi, 0.0, 0.0, 1.0)
    assert edge.stable is None
    assert edge._replace(tau=1.0 - 1e-9).stable is True
    assert edge._replace(tau=1.0 + 1e-9).stable is False
    assert LinearDelay(-1.0, 1.0, 0.0, 0.0, 1.0).stable is False
    assert LinearDelay(-1.0, 1.0, 0.0, 0.0, 1.0).noise_integral == np.inf
