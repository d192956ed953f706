"""The exact solutions of geometric Brownian motion and of the Ornstein-Uhlenbeck process."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from scipy.special import chdtri

from joined_noise import aggregate
from sdaeverify import SDE, ParameterError
from sdaeverify.arrays import Array
from sdaeverify.noise.brownian import Source, brownian_steps
from sdaeverify_problems.gbm import gbm
from sdaeverify_problems.hyperbolic_pair import hyperbolic_pair
from sdaeverify_problems.ou import exponential_integral, ou

EPS = np.finfo(float).eps


def rounding(z: float) -> float:
    """Return what summing 16 values of the kernel e^{-zq} rounds: a few eps each of the largest one.

    The factor 12 |q - 1/2| <= 6 of beta is the largest that multiplies them.
    """
    return 16 * 8 * EPS * max(1.0, float(np.exp(-z)))


def closed_forms(z: float) -> tuple[float, float, float]:
    """Return Var Y / h, Cov(Y, dW) / h and Cov(Y, H) / h for Y = int e^{-a(h-s)} dW(s), z = a h, to 16 digits.

    Var Y = (1 - e^{-2ah}) / (2a); Cov(Y, dW) = (1 - e^{-ah}) / a; and, H having the kernel q - 1/2 with q = (h-s)/h,
    Cov(Y, H) = h { [1 - (1 + z) e^{-z}] / z^2 - (1 - e^{-z}) / (2z) }.
    """
    with localcontext() as context:
        context.prec = 80
        x = Decimal(z)
        once, twice = (-x).exp(), (-2 * x).exp()
        values = (
            (1 - twice) / (2 * x),
            (1 - once) / x,
            (1 - (1 + x) * once) / x**2 - (1 - once) / (2 * x),
        )
        return tuple(float(value) for value in values)


def left_over(z: float) -> float:
    """Return the share of Var Y / h that neither dW nor H explains, with 80 digits on the way."""
    with localcontext() as context:
        context.prec = 80
        x = Decimal(z)
        once, twice = (-x).exp(), (-2 * x).exp()
        with_H = (1 - (1 + x) * once) / x**2 - (1 - once) / (2 * x)
        return float((1 - twice) / (2 * x) - ((1 - once) / x) ** 2 - 12 * with_H**2)


ZS = [1e-12, -1e-8, 1e-3, -0.3, 0.05, 0.5, 1.0, -2.0, 4.0, -4.0]


@pytest.mark.parametrize("z", ZS)
def test_the_exponential_integral_has_its_covariances(z: float) -> None:
    """Variance and covariances with dW and H of alpha dW + beta H + rho sqrt(h) xi are the closed forms."""
    alpha, beta, rho = exponential_integral(z)
    variance, with_dW, with_H = closed_forms(z)
    error = rounding(z)

    assert abs(alpha - with_dW) <= error
    assert abs(beta / 12 - with_H) <= error / 12
    assert abs(alpha**2 + beta**2 / 12 + rho**2 - variance) <= 4 * error * max(1.0, with_dW)


@pytest.mark.parametrize("z", ZS)
def test_what_increments_do_not_explain_does_not_cancel(z: float) -> None:
    """The remainder's deviation, about z^2 / 27, is right to rounding of the kernel and not of its square root."""
    assert abs(exponential_integral(z)[2] - np.sqrt(left_over(z))) <= rounding(z)


def joint_covariance(z: float) -> Array:
    """Return the covariance of (dW, H, Y) over a step of length 1."""
    alpha, beta, rho = exponential_integral(z)
    factor = np.array([[1.0, 0.0, 0.0], [0.0, np.sqrt(1 / 12), 0.0], [alpha, beta * np.sqrt(1 / 12), rho]])
    return factor @ factor.T


@pytest.mark.parametrize("z", [0.02, -0.7, 1.0, 4.0])
def test_the_exponential_integral_composes(z: float) -> None:
    """The law of (dW, H, Y) over a step is that of two halves joined: Y = e^{-z/2} Y_1 + Y_2."""
    half = np.exp(-z / 2)
    join = np.array(
        [
            [1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            [0.25, 0.5, 0.0, -0.25, 0.5, 0.0],
            [0.0, 0.0, half, 0.0, 0.0, 1.0],
        ]
    )
    halves = np.kron(np.eye(2), 0.5 * joint_covariance(z / 2))

    assert np.abs(join @ halves @ join.T - joint_covariance(z)).max() <= 4 * rounding(z) * max(1.0, half**2)


def test_the_exponential_integral_is_that_of_the_path() -> None:
    """On a refined path, what dW and H leave of the integral has the promised variance, at level 1e-6."""
    a, h, paths, depth = 2.0, 0.5, 400, 9
    levels = next(brownian_steps(Source(4, "integral", 0, paths), 1, h, depth))
    (whole, fine), n = (levels[0], levels[-1]), 2**depth
    middles = (np.arange(n) + 0.5) * h / n
    integral = np.exp(-a * (h - middles)) @ fine.dW[:, 0]
    alpha, beta, rho = exponential_integral(a * h)

    rest = integral - alpha * whole.dW[0, 0] - beta * whole.H[0, 0]

    # The midpoint rule misses a / sqrt(12) of the kernel times a step's length, below a hundredth of rho.
    assert a * h / n / np.sqrt(12) < 0.03 * rho
    ratio = np.sum(rest**2) / (rho**2 * h)
    assert chdtri(paths, 1 - 5e-7) <= ratio <= chdtri(paths, 5e-7)


@pytest.mark.parametrize(("a", "b"), [(0.5, 0.6), (-3.0, 2.0)])
def test_geometric_brownian_motion_composes(a: float, b: float) -> None:
    """Two steps on refined noise are one step on the joined noise."""
    truth, h = gbm(a=a, b=b).pathwise, 0.25
    assert truth is not None
    *_, halves = next(brownian_steps(Source(3, "gbm", 0, 100), 1, h, 1))

    once = truth.advance(truth.start(100), 0.0, h, aggregate(halves).increment(0))
    twice = truth.advance(truth.start(100), 0.0, h / 2, halves.increment(0))
    twice = truth.advance(twice, h / 2, h / 2, halves.increment(1))

    # An exponential rounds its argument's error, a few eps times at most 1 + |b dW|.
    assert np.abs(once / twice - 1.0).max() <= 16 * EPS * (1.0 + abs(b) * np.abs(halves.dW).max())


@pytest.mark.parametrize(("a", "b"), [(0.5, 0.6), (-3.0, 2.0)])
def test_geometric_brownian_motion_solves_its_equation(a: float, b: float) -> None:
    """By Ito's formula, with x(t, W) the solution: d_t x + d_WW x / 2 = f(x), d_W x = B(x)."""
    problem, t = gbm(a=a, b=b), 0.7
    assert problem.pathwise is not None
    W, s = np.linspace(-1.0, 1.0, 9), 2.0**-10

    def x(t: float, W: Array) -> Array:
        noise = next(brownian_steps(Source(0, "", 0, len(W)), 1, t, 0))[0].increment(0)
        return problem.pathwise.advance(problem.pathwise.start(len(W)), 0.0, t, noise._replace(dW=W[None]))

    along = (x(t, W + s) - x(t, W - s)) / (2 * s)
    rate = (x(t + s, W) - x(t - s, W)) / (2 * s)
    bend = (x(t, W + s) - 2 * x(t, W) + x(t, W - s)) / s**2

    # Differences are wrong by s^2/6 of the third derivative, at most max(|a - b^2/2|, b)^4 x.
    error = s**2 * max(abs(a - b * b / 2), b, 1.0) ** 4 * x(t, W)
    assert np.all(np.abs(along - problem.diffusion(t, x(t, W))[:, 0]) <= error)
    assert np.all(np.abs(rate + 0.5 * bend - problem.drift(t, x(t, W))) <= error)


def test_an_ornstein_uhlenbeck_step_is_its_formula() -> None:
    """x+ = e^{-ah} x + sigma Y, with Y the exponential integral."""
    problem = ou(a=1.5, sigma=0.3)
    assert isinstance(problem, SDE)
    assert problem.pathwise is not None
    h, x = 0.2, np.array([[0.4, -2.0]])
    noise = next(brownian_steps(Source(6, "ou", 0, 2), 1, h, 0))[0].increment(0)._replace(xi=np.ones((1, 2)))
    alpha, beta, rho = exponential_integral(0.3)

    new = problem.pathwise.advance(x, 0.0, h, noise)

    integral = alpha * noise.dW + beta * noise.H + rho * np.sqrt(h)
    assert np.abs(new - (np.exp(-0.3) * x + 0.3 * integral)).max() <= 16 * EPS


def test_a_sine_of_too_wide_a_variable_is_refused() -> None:
    """Where few paths carry all of sinh y_2, no sample shows an order: the parameters are rejected."""
    with pytest.raises(ParameterError, match="standard deviation of 3 at the end, got 24:"):
        hyperbolic_pair(c=3.15, b_1=2.76, b_2=0.124, x_1=0.793, horizon=2.84)
