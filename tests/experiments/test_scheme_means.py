"""Means of a scheme without sampling: recursions of the whole history, done another way."""

import numpy as np
import pytest

from facade import SETS, Coefficients, EulerMaruyama, SchemeValue, StochasticTheta, gbm, problem
from sdaeverify_lab.papers.scheme_means import scheme_means


def whole_history(at, theta, steps, horizon):
    """Return E x_n and E x_n^2, n = 0..steps, by the second moments of (1, x_n, ..., x_{n-m}), the delay being m h.

    (1 - h theta A) x_{n+1} = (1 + h (1 - theta) A) x_n + h B (theta x_{n+1-m} + (1 - theta) x_{n-m})
                              + (c x_n + d x_{n-m}) dW,   with A = a + q and l = 0.
    """
    a, b, c, d, _, q = at
    A, h = a + q, horizon / steps
    m = round(1.0 / h)
    F, G = np.eye(m + 2, k=-1), np.zeros((m + 2, m + 2))
    F[0, 0], F[1] = 1.0, 0.0
    F[1, 1] += 1.0 + h * (1.0 - theta) * A
    F[1, m] += h * b * theta
    F[1, m + 1] += h * b * (1.0 - theta)
    G[1, 1] += c
    G[1, m + 1] += d
    F[1], G[1] = F[1] / (1.0 - h * theta * A), G[1] / (1.0 - h * theta * A)
    z = np.array([1.0, *(1.0 - h * i for i in range(m + 1))])
    P, found = np.outer(z, z), [(1.0, 1.0)]
    for _ in range(steps):
        P = F @ P @ F.T + h * G @ P @ G.T
        found.append((P[0, 1], P[1, 1]))
    return found


@pytest.mark.parametrize("name", ["I", "II", "III", "V"])
@pytest.mark.parametrize("theta", [0.0, 0.2, 1.0])
def test_whole_history(name, theta):
    """Means of x, x^2 and y at all times are those of the recursion on the whole history."""
    at = SETS[name]._replace(l=0.0)
    scheme, steps, horizon = StochasticTheta(theta=theta), 24, 3.0
    values = [SchemeValue("s", steps, phi, n) for phi in ("x", "x^2", "y") for n in (1, 7, 8, 9, 24)]

    found = scheme_means(problem(at, horizon), values, {"s": scheme})

    expected = whole_history(at, theta, steps, horizon)
    for value in values:
        x, square = expected[value.at]
        # Rounding of 24 recursions in moments of size 100 at most.
        wanted = {"x": x, "x^2": square, "y": at.q * x}[value.observable]
        assert found[value].value == pytest.approx(wanted, rel=1e-11, abs=1e-13)


def test_sheet():
    """Set I is a geometric Brownian motion, and E x_n^2 is the n-th power of a factor in closed form."""
    value = SchemeValue("s", 320, "x^2", 320)

    (found,) = scheme_means(
        problem(SETS["I"]._replace(c=1.6), 10.0), [value], {"s": StochasticTheta(theta=0.2)}
    ).values()

    h, theta, c = 1.0 / 32.0, 0.2, 1.6
    factor = ((1.0 - (1.0 - theta) * h) ** 2 + h * c * c) / (1.0 + theta * h) ** 2
    assert factor == pytest.approx(1.0179, abs=5e-5)
    assert found.value == pytest.approx(factor**320, rel=1e-11)
    assert found.factor == pytest.approx(factor, rel=1e-9)
    assert found.rate == pytest.approx(2.0 * -1.0 + c * c, rel=1e-9)


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("name", "rate"), [("II", 0.8049), ("III", -2.71), ("IV", -1.86), ("V", 0.72), ("VI", -1.10)]
)
def test_growth(name, rate):
    """With l = 0, second moments of the equation grow as known, and those of the scheme tend to that with h."""
    values = [SchemeValue("s", steps, "x^2", steps) for steps in (128, 256)]

    coarse, fine = scheme_means(
        problem(SETS[name]._replace(l=0.0), 1.0), values, {"s": StochasticTheta(theta=0.2)}
    ).values()

    assert coarse.rate == fine.rate == pytest.approx(rate, abs=0.005)
    off = [np.log(found.factor) * steps - fine.rate for found, steps in ((coarse, 128), (fine, 256))]
    # Of first order: half as far off with steps half as long.
    assert off[0] / off[1] == pytest.approx(2.0, abs=0.2)


def test_interpolated_mesh():
    """Where the delay is no multiple of h, E x^2 is that of many paths, within four standard errors."""
    scheme, steps, at = StochasticTheta(theta=0.5), 7, Coefficients(-1.0, 0.5, 0.5, 1.0, 0.0, 0.2)
    view = problem(at, 2.0)
    exact = scheme_means(view, [SchemeValue("s", steps, "x^2", steps)], {"s": scheme}).popitem()[1].value

    h, paths, rng = 2.0 / steps, 200_000, np.random.Generator(np.random.Philox(5))
    x, A, m = [np.ones(paths)], at.a + at.q, 4
    delta = m - 1.0 / h

    def lagged(n):
        return delta * x[n - m + 1] + (1.0 - delta) * x[n - m] if n * h > 1.0 else np.full(paths, n * h)

    for n in range(steps):
        drift = 0.5 * h * (at.b * lagged(n + 1) + A * x[n] + at.b * lagged(n))
        noise = np.sqrt(h) * rng.standard_normal(paths) * (at.c * x[n] + at.d * lagged(n))
        x.append((x[n] + drift + noise) / (1.0 - 0.5 * h * A))
    squares = x[-1] ** 2
    assert abs(squares.mean() - exact) < 4.0 * squares.std() / paths**0.5
    assert 4.0 * squares.std() / paths**0.5 < 0.03 * exact


def test_what_has_no_exact_mean():
    """Nothing is said of a cubic observable, an unknown one, a nonlinear equation, or one without a delay."""
    scheme = StochasticTheta(theta=0.5)
    linear, nonlinear = problem(SETS["II"], 2.0), problem(SETS["IV"], 2.0)

    for observable in ("x^3", "z"):
        assert scheme_means(linear, [SchemeValue("s", 8, observable, 8)], {"s": scheme}) == {}
    assert scheme_means(nonlinear, [SchemeValue("s", 8, "x^2", 8)], {"s": scheme}) == {}
    assert scheme_means(gbm(), [SchemeValue("s", 8, "x^2", 8)], {"s": EulerMaruyama()}) == {}


class Refusing(StochasticTheta):
    name = "refusing"

    def step(self, problem, state, t, h, noise):
        raise FloatingPointError("not at these states")


def test_step_that_cannot_be_asked():
    """A step that raises where it is asked leaves no mean, and costs no other scheme its own."""
    schemes = {"wrong": Refusing(), "right": StochasticTheta()}
    wrong, right = (SchemeValue(label, 8, "x^2", 8) for label in schemes)

    assert list(scheme_means(problem(SETS["II"], 2.0), [wrong, right], schemes)) == [right]
