"""The forced Ornstein-Uhlenbeck process against its own differential equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sdaeverify.noise.brownian import Source, brownian_steps
from sdaeverify_problems.forced_ou import forced_ou


@pytest.mark.parametrize("omega", [0.5, 2.0, 7.0])
def test_moments_solve_their_equations(omega):
    """Mean and second moment agree with a numerical solution of m' = -a m + F, s' = -2 a s + 2 F m + sigma^2."""
    problem = forced_ou(a=1.3, amplitude=0.8, omega=omega, sigma=0.6)

    def rates(t, y):
        force = 0.8 * np.cos(omega * t)
        return [-1.3 * y[0] + force, -2.6 * y[1] + 2 * force * y[0] + 0.36]

    expected = solve_ivp(rates, (0.0, 1.0), [1.0, 1.0], rtol=1e-11, atol=1e-12).y[:, -1]
    moments = {moment.observable: moment.value(1.0) for moment in problem.truths if hasattr(moment, "observable")}
    assert (moments["x"], moments["x^2"]) == pytest.approx(tuple(expected), rel=1e-8)


def test_path_is_the_limit_of_heun_steps():
    """On the same Brownian paths, Heun steps tend to the pathwise truth with order 1."""
    problem = forced_ou(omega=5.0)
    levels = next(brownian_steps(Source(3, "forced", 0, 500), 1, 1.0, 9))
    truth = problem.pathwise

    def exact(level):
        noise, z = levels[level], truth.start(500)
        rng = np.random.default_rng(1)
        h = 1.0 / len(noise.dW)
        for n in range(len(noise.dW)):
            increment = noise.increment(n)._replace(xi=rng.standard_normal((1, 500)))
            z = truth.advance(z, n * h, h, increment)
        return z

    def heun(level):
        noise, x = levels[level], problem.initial(500)
        h = 1.0 / len(noise.dW)
        for n in range(len(noise.dW)):
            f, kick = problem.drift(n * h, x), 0.7 * noise.dW[n]
            x = x + 0.5 * h * (f + problem.drift(n * h + h, x + h * f + kick)) + kick
        return x

    z = exact(9)
    coarse, fine = (np.abs(heun(level) - z).mean() for level in (5, 7))

    assert np.log2(coarse / fine) / 2 == pytest.approx(1.0, abs=0.1)


def test_rate_must_be_positive():
    """Without damping there is no such solution."""
    with pytest.raises(ValueError, match="a must be positive"):
        forced_ou(a=0.0)
