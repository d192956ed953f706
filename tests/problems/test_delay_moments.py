"""Moments of linear delay equations against closed forms, and against Euler's method with all its covariances."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from facade import (
    LinearDelay,
    ScalarDelay,
    StochasticTheta,
    delay_linear,
    delay_ou,
    delay_test,
    probe_step,
    run_moments,
    run_start,
)
from facade import _equilibrium as equilibrium
from sdaeverify import Array, DelaySDAE, InvariantMean, MeanSquareStability, Moment
from sdaeverify_problems.delays._renewal_equation import mean, second

# A, B, c, d, s, tau, x_0 and slope: all terms at once, and each of them missing.
EQUATIONS = {
    "all": ScalarDelay(-0.7, 0.4, 0.3, -0.5, 0.2, 1.0, 1.0, 0.5),
    "no delay in the drift": ScalarDelay(-0.7, 0.0, 0.3, -0.5, 0.2, 0.5, 1.0, 0.0),
    "additive": ScalarDelay(-0.5, -1.0, 0.0, 0.0, 0.7, 1.0, 1.0, 0.0),
    "set II": ScalarDelay(-1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0),
    "growing": ScalarDelay(0.3, -0.8, 0.2, 0.6, 0.0, 0.8, 1.0, -0.3),
}


def euler(at: ScalarDelay, t: float, m: int) -> Array:
    """Return E x and E x^2 of Euler's method with h = tau/m, by the covariances of all pairs of times."""
    h, n = at.tau / m, round(t * m / at.tau)
    means = [at.past(-k * h) for k in range(m, -1, -1)]
    R = np.zeros((m + n + 1, m + n + 1))
    R[: m + 1, : m + 1] = np.outer(means, means)
    for now in range(m, m + n):
        old = now - m
        means.append((1.0 + h * at.A) * means[now] + h * at.B * means[old])
        row = (1.0 + h * at.A) * R[now, : now + 1] + h * at.B * R[old, : now + 1]
        R[now + 1, : now + 1] = R[: now + 1, now + 1] = row
        g = at.c**2 * R[now, now] + at.d**2 * R[old, old] + 2.0 * at.c * at.d * R[now, old]
        g += 2.0 * at.s * (at.c * means[now] + at.d * means[old]) + at.s**2
        R[now + 1, now + 1] = (1.0 + h * at.A) * row[now] + h * at.B * row[old] + h * g
    return np.array([means[-1], R[-1, -1]])


def extrapolated(value: Callable[[int], Array], coarsest: int = 8, levels: int = 6) -> Array:
    """Return the limit for h to 0 of what has an expansion in h."""
    table = [value(coarsest * 2**level) for level in range(levels)]
    for power in range(1, levels):
        table = [(2.0**power * b - a) / (2.0**power - 1.0) for a, b in pairwise(table)]
    return table[0]


@pytest.mark.sweep
@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("delays", [1.0, 2.5, 4.0])
def test_moments_are_the_limit_of_eulers(name: str, delays: float) -> None:
    """E x and E x^2 agree with the extrapolated ones of Euler's method, within and between intervals."""
    equation = EQUATIONS[name]
    t = delays * equation.tau

    expected = extrapolated(lambda m: euler(equation, t, m))

    assert [mean(equation, t), second(equation, t)] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(
    ("A", "B", "tau", "t", "meshes"),
    [
        (-10.0, 6.0, 1.0, 2.0, (64, 128, 256, 512)),
        (-5.0, 4.5, 0.05, 2.5, (4, 8, 16, 32)),
    ],
)
def test_moments_over_stiff_and_over_many_delays_are_the_limit_of_implicit_eulers(
    A: float, B: float, tau: float, t: float, meshes: tuple[int, ...]
) -> None:
    """E x and E x^2 agree with the extrapolated ones of implicit Euler's linear recursion."""
    problem = delay_linear(A, B, 0.5, 0.7, tau, horizon=t)
    table = []
    for m in meshes:
        scheme, h = StochasticTheta(theta=1.0), tau / m
        step, steps = probe_step(scheme, problem, h).step, round(t / h)
        run = run_moments(step, problem.mesh(h), run_start(scheme, problem, h, steps), steps)
        table.append(np.array([run.mean[-1, 0], run.second[-1, 0, 0]]))
    for power in (2.0, 4.0, 8.0):
        table = [(power * b - a) / (power - 1.0) for a, b in pairwise(table)]

    equation = ScalarDelay(A, B, 0.5, 0.7, 0.0, tau, 1.0, 0.0)
    assert (mean(equation, t), second(equation, t)) == pytest.approx(tuple(table[0]), rel=1e-6)


@pytest.mark.parametrize(
    ("problem", "known"),
    [
        (lambda: delay_test("IV"), set()),
        (lambda: delay_test("IV", horizon=1.0), {"x", "x^2", "y"}),
        (lambda: delay_test("II"), {"x", "x^2", "y"}),
        (lambda: delay_test("II", horizon=40.0), {"x", "x^2", "y"}),
        (lambda: delay_linear(A=-1000.0, tau=0.01), {"x", "x^2"}),
        (lambda: delay_linear(tau=0.001), {"x", "x^2"}),
        (lambda: delay_linear(tau=0.0009), set()),
    ],
)
def test_moments_are_attached_where_they_hold_and_can_be_found(
    problem: Callable[[], DelaySDAE], known: set[str]
) -> None:
    """With a sine only up to the first delay, and for no more delays than can be afforded."""
    assert {truth.observable for truth in problem().truths if isinstance(truth, Moment)} == known


def stable(problem: DelaySDAE) -> list[bool]:
    return [truth.stable for truth in problem.truths if isinstance(truth, MeanSquareStability)]


def test_no_law_is_declared_where_the_mean_grows() -> None:
    """Of s = A + B e^-s one root has a positive real part: no invariant law, no relaxation time, no stability.

    Two real roots of s = .6 - .5466 e^-s are positive, of s = 2 - 1.822 e^(-.3 s) the larger one.
    """
    for problem in (delay_ou(B=-4.0), delay_ou(A=0.6, B=-0.5466)):
        assert problem.relaxation_time == np.inf
        assert not any(isinstance(truth, InvariantMean) for truth in problem.truths)
    assert stable(delay_linear(A=2.0, B=-1.822, c=0.0, d=0.1, tau=0.3)) == [False]


@pytest.mark.parametrize(("d", "expected"), [(1.7749, True), (1.7750, False)])
def test_the_boundary_of_mean_square_stability(d: float, expected: bool) -> None:
    """For A = -2, B = 1 and c = 0 it is at d = 1.7749729938."""
    assert stable(delay_linear(A=-2.0, B=1.0, c=0.0, d=d)) == [expected]


@pytest.mark.parametrize("parameters", [{"A": -800.0}, {"tau": 400.0}, {"A": -1e5, "B": -9e4, "tau": 30.0}])
def test_a_truth_of_stability_survives_where_the_exponential_overflows(parameters: dict[str, float]) -> None:
    """By Hayes' criterion r decays for |B| < -A whatever tau is, and little noise leaves E x^2 stable."""
    assert stable(delay_linear(**parameters)) == [True]


def test_stability_agrees_with_the_frameworks_and_with_hayes_criterion() -> None:
    """On random coefficients, with both answers: in the mean with rates up to 1e5, in mean square up to 4."""
    rng, found = np.random.default_rng(6), set()
    for A, B, tau in 10.0 ** rng.uniform(-2.0, [5.0, 5.0, 3.0], (300, 3)) * rng.choice([-1.0, 1.0], (300, 3)):
        at = ScalarDelay(A, B, 0.0, 0.0, 0.0, abs(tau), 1.0, 0.0)
        decays = A + B < 0.0 and (A <= B or abs(tau) * np.sqrt(B * B - A * A) < np.arccos(-A / B))
        assert (equilibrium.rate(at) < 0.0) == LinearDelay(A, B, 0.0, 0.0, abs(tau)).mean_decays == decays
        found.add(decays)
    for A, B, c, d in rng.uniform(-2.0, 2.0, (200, 4)) - np.array([2.0, 0.0, 0.0, 0.0]):
        answer = equilibrium.mean_square_stable(ScalarDelay(A, B, c, d, 0.0, 1.0, 1.0, 0.0))
        assert answer == LinearDelay(A, B, c, d, 1.0).stable
        found.add(("in mean square", answer))
    assert len(found) == 4


@pytest.mark.parametrize(("A", "B"), [(-800.0, 700.0), (-900.0, -850.0)])
def test_the_stationary_variance_is_the_integral_of_the_spectrum(A: float, B: float) -> None:
    """sigma^2 times the integral of 1/(2 pi |i w - A - B e^(-i w tau)|^2) over all frequencies."""
    sigma, step, end = 0.7, 0.02, 4e4
    known = {t.observable: t.value for t in delay_ou(A, B, sigma).truths if isinstance(t, InvariantMean)}
    w = np.arange(0.5 * step, end, step)
    density = 1.0 / np.abs(1j * w - A - B * np.exp(-1j * w)) ** 2
    # Beyond the end, 1/w^2 up to (A/w)^2 of it.
    assert known["x^2"] == pytest.approx(sigma**2 / np.pi * (step * density.sum() + 1.0 / end), rel=1e-5)
    assert (known["x"], known["x^3"]) == (0.0, 0.0)
