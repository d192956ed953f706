"""Expectations that problems know, against quadrature of Gaussian laws and against samples of the solution."""

from collections.abc import Callable

import numpy as np
import pytest

from facade import gbm, linear_test, ou, pendulum, pendulum_tangential, pendulum_velocity_noise
from sdaeverify import Array, HolonomicSDAE, MeanSquareStability, Moment, Problem

EPS = np.finfo(float).eps


def moments(problem: Problem) -> dict[str, Moment]:
    return {truth.observable: truth for truth in problem.truths if isinstance(truth, Moment)}


TIMES = (0.0, 0.3, 1.0, 2.0)


def gaussian(theta_0: float, omega_0: float, t: float) -> tuple[Array, Array]:
    """Return mean and covariance of (theta, omega) for dtheta = omega dt, domega = dW.

    The covariance is int_0^t k k^T ds with the response k = (t - s, 1) to a kick at s, exact with two nodes.
    """
    nodes, weights = np.polynomial.legendre.leggauss(2)
    s = 0.5 * t * (1 + nodes)
    kicks = np.stack([t - s, np.ones(2)])
    return np.array([theta_0 + omega_0 * t, omega_0]), (kicks * 0.5 * t * weights) @ kicks.T


def under(f: Callable[[Array, Array], Array], mean: Array, covariance: Array) -> float:
    """Return E f(theta, omega) under a normal law by Gauss-Hermite quadrature with 40 by 40 nodes."""
    nodes, weights = np.polynomial.hermite_e.hermegauss(40)
    u = np.stack(np.meshgrid(nodes, nodes)).reshape(2, -1)
    w = np.outer(weights, weights).ravel() / (2 * np.pi)
    # Lower triangular, and zero at time 0 where there is nothing to factorise.
    root = np.linalg.cholesky(covariance) if covariance.any() else np.zeros((2, 2))
    return float(w @ f(*(mean[:, None] + root @ u)))


GAUSSIAN: dict[str, Callable[[Array, Array], Array]] = {
    "r_1": lambda theta, omega: np.sin(theta),
    "r_2": lambda theta, omega: -np.cos(theta),
    "v_1": lambda theta, omega: omega * np.cos(theta),
    "v_2": lambda theta, omega: omega * np.sin(theta),
    "|v|^2": lambda theta, omega: omega**2,
    "|v|^4": lambda theta, omega: omega**4,
}
FREE: dict[str, Callable[[float, float], HolonomicSDAE]] = {
    "isotropic": lambda theta_0, omega_0: pendulum(c_g=0.0, theta_0=theta_0, omega_0=omega_0),
    "tangential": lambda theta_0, omega_0: pendulum_tangential(theta_0=theta_0, omega_0=omega_0),
}


@pytest.mark.parametrize("noise", FREE)
@pytest.mark.parametrize("start", [(0.5, 0.5), (2.0, -1.5)])
def test_moments_of_the_free_pendulum_are_those_of_a_gaussian(noise: str, start: tuple[float, float]) -> None:
    """Moments of position and velocity agree with quadrature of the Gaussian law of angle and angular velocity."""
    known = moments(FREE[noise](*start))
    for t in TIMES:
        values = {name: under(f, *gaussian(*start, t)) for name, f in GAUSSIAN.items()}
        # 1600 positive weights that sum to one, of values up to about (1.5 + 9 sqrt 2)^4 weighted by their moments.
        assert {name: known[name].value(t) for name in values} == pytest.approx(values, rel=1e-12, abs=1e-13)


@pytest.mark.parametrize(("sigma", "gamma"), [(0.5, 0.0), (0.3, 0.7), (1.0, 0.5), (0.4, 0.08)])
def test_moments_with_velocity_noise_are_those_of_a_lognormal(sigma: float, gamma: float) -> None:
    """Moments of |v| agree with quadrature over W(t), and E mu with that of its rate E |v|^2 over time."""
    known = moments(pendulum_velocity_noise(sigma=sigma, gamma=gamma, omega_0=1.3))
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    weights = weights / np.sqrt(2 * np.pi)

    def speed(power: int, t: float) -> float:
        k = gamma + 0.5 * sigma**2
        return float(weights @ (1.3 * np.exp(-k * t + sigma * np.sqrt(t) * nodes)) ** power)

    q, w = np.polynomial.legendre.leggauss(12)
    for t in TIMES[:3]:
        rates = [speed(2, 0.5 * t * (1 + x)) for x in q]
        # Sixty positive terms, each an exponential whose argument, at most 40, is rounded.
        error = 60 * EPS * 4
        assert known["|v|^2"].value(t) == pytest.approx(speed(2, t), rel=error)
        assert known["|v|^4"].value(t) == pytest.approx(speed(4, t), rel=error)
        assert known["mu"].value(t) == pytest.approx(0.5 * t * float(w @ rates), rel=error)


STABILITY: list[tuple[Problem, str]] = [
    *[(gbm(a=a, b=b), "x^2") for a, b in ((0.1, 0.2), (-0.1, 0.6), (-0.2, 0.6))],
    *[(ou(a=a, sigma=sigma), "x^2") for a in (1.0, -0.5) for sigma in (0.0, 1.0)],
    *[(linear_test(b=b), "x^2") for b in (0.5, 2.1)],
    *[(pendulum_velocity_noise(sigma=0.5, gamma=gamma), "|v|^2") for gamma in (0.0, 0.1, 0.15)],
]


@pytest.mark.parametrize(("problem", "observable"), STABILITY)
def test_mean_square_stability_is_that_of_the_second_moment(problem: Problem, observable: str) -> None:
    """A problem says it is mean-square stable exactly if its known second moment tends to zero."""
    (truth,) = [truth for truth in problem.truths if isinstance(truth, MeanSquareStability)]
    second = moments(problem)[observable]

    assert truth.stable == (second.value(300.0) < 1e-3 * second.value(0.0))
