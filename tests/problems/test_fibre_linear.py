"""The linearised fibre as an equation with an exact solution on each path."""

import numpy as np
import pytest

from sdaeverify.noise.brownian import Increment, Source, brownian_steps
from sdaeverify_problems._chain import clamped_chain
from sdaeverify_problems._fibre import Fibre
from sdaeverify_problems._gaussian_step import gaussian_step
from sdaeverify_problems._hanging_fibre import hanging_fibre
from sdaeverify_problems.fibre_linear import fibre_linear
from sdaeverify_problems.ou import exponential_integral
from sdaeverify_schemes.sra1 import SRA1

N = 3


def fibre(alpha=4.0, **others):
    return hanging_fibre(Fibre(chain=clamped_chain(N, 2), alpha=alpha, **others), 1.0)


@pytest.mark.parametrize("h", [1e-7, 1e-4, 1e-2])
def test_exact_steps_have_the_covariance_of_the_solution(h):
    """The parts made of dW, H and further normals add up to C(h), in every component."""
    linear = fibre(alpha=0.5)
    step = gaussian_step(linear.generator, linear.noise, h)
    parts = h * step.of_dW @ step.of_dW.T + h / 12 * step.of_H @ step.of_H.T + step.of_xi @ step.of_xi.T
    expected = linear.covariance(h)
    scale = np.sqrt(np.diag(expected))

    assert np.abs((parts - expected) / np.outer(scale, scale)).max() < 1e-11


def test_exact_steps_of_one_variable_are_those_of_ornstein_and_uhlenbeck():
    """With A = -a the coefficients are the scalar ones."""
    step = gaussian_step(np.array([[-1.7]]), np.array([[0.6]]), 0.3)
    alpha, beta, rho = exponential_integral(1.7 * 0.3)
    found = [np.abs(part).item() for part in (step.of_dW, step.of_H, step.of_xi)]

    assert step.propagator.item() == pytest.approx(np.exp(-0.51), rel=1e-14)
    assert found == pytest.approx([0.6 * alpha, 0.6 * abs(beta), 0.6 * np.sqrt(0.3) * rho], rel=1e-9)


def run(advance, z, noise, horizon, xi=None):
    h = horizon / len(noise.dW)
    for n in range(len(noise.dW)):
        increment = noise.increment(n)
        z = advance(z, n * h, h, increment if xi is None else increment._replace(xi=xi))
    return z


def test_exact_path_is_the_limit_of_fine_steps():
    """SRA1 steps on the same Brownian paths come near the exact solution like h^2."""
    problem, paths = fibre_linear(N=N, alpha=1.0), 200
    levels = next(brownian_steps(Source(3, "linear", 0, paths), N, problem.horizon, 10))
    silent = np.zeros((problem.pathwise.extra_normals, paths))
    # Over 1024 steps, what dW and H leave open is far below the errors compared.
    exact = run(problem.pathwise.advance, problem.pathwise.start(paths), levels[10], problem.horizon, silent)

    def by_scheme(z, t, h, noise):
        return SRA1().step(problem, z, t, h, noise).state

    errors = [
        np.sqrt(((run(by_scheme, problem.initial(paths), levels[k], problem.horizon) - exact) ** 2).mean(axis=1))
        for k in (4, 6)
    ]
    orders = np.log2(errors[0] / errors[1]) / 2

    assert orders.min() > 1.8
    assert errors[1].max() < 1e-3 * np.abs(exact).max()


def test_exact_paths_have_the_promised_moments():
    """Means and variances of tip and speed over 20000 paths agree with the truths within four standard errors."""
    problem, paths = fibre_linear(N=N), 20000
    rng, h = np.random.default_rng(8), problem.horizon / 3
    z = problem.pathwise.start(paths)
    for n in range(3):
        dW, H, xi = (scale * rng.standard_normal((rows, paths)) for scale, rows in drawn(problem, h))
        z = problem.pathwise.advance(z, n * h, h, Increment(dW, H, xi))
    for moment in (truth for truth in problem.truths if truth is not problem.pathwise):
        values = problem.observables[moment.observable](problem.horizon, problem.parts(z))
        assert values.mean() == pytest.approx(moment.value(problem.horizon), abs=4 * values.std() / np.sqrt(paths))


def drawn(problem, h):
    return ((np.sqrt(h), N), (np.sqrt(h / 12), N), (1.0, problem.pathwise.extra_normals))


def test_drift_and_noise_are_those_of_the_linear_fibre():
    """They make z' = A z + (0, F) + (0, sigma W')."""
    problem, linear = fibre_linear(N=N), fibre(beta=0.03)
    x = np.random.default_rng(9).standard_normal((2 * N, 4))
    force = np.concatenate([np.zeros(N), linear.F])[:, None]

    np.testing.assert_allclose(problem.drift(0.0, x), linear.generator @ x + force, rtol=0.0, atol=1e-10)
    np.testing.assert_array_equal(problem.diffusion(0.0, x)[..., 0], linear.noise)
