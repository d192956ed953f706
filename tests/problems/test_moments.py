"""Expectations that problems know, against quadrature of Gaussian laws and against samples of the solution."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from scipy.special import ndtri

from sdaeverify.arrays import Array
from sdaeverify.forms import HolonomicSDAE, Problem
from sdaeverify.forms.truths import MeanSquareStability, Moment
from sdaeverify.noise.brownian import Source, brownian_steps
from sdaeverify_problems.circle import circle
from sdaeverify_problems.damped_pendulum import damped_pendulum
from sdaeverify_problems.gbm import gbm, linear_test
from sdaeverify_problems.growing_volatility import growing_volatility
from sdaeverify_problems.hyperbolic import hyperbolic
from sdaeverify_problems.hyperbolic_pair import hyperbolic_pair
from sdaeverify_problems.ou import ou
from sdaeverify_problems.pendulum import pendulum
from sdaeverify_problems.pendulum_tangential import pendulum_tangential
from sdaeverify_problems.pendulum_velocity_noise import pendulum_velocity_noise
from sdaeverify_problems.spiral import spiral

EPS = np.finfo(float).eps
PROBLEMS: dict[str, Callable[[], Problem]] = {
    "gbm": gbm,
    "gbm, decaying": lambda: gbm(a=-1.0, b=0.4, x_0=-2.0),
    "growing volatility": lambda: growing_volatility(b=0.2, x_0=-2.0),
    "hyperbolic": lambda: hyperbolic(a=0.8, b=0.3),
    "hyperbolic pair": lambda: hyperbolic_pair(b_1=0.3, b_2=0.2, x_2=-0.7),
    "spiral": lambda: spiral(beta=0.3),
    "ou": ou,
    "ou, growing": lambda: ou(a=-0.8, sigma=0.3, x_0=0.5),
    "pendulum": pendulum,
    "pendulum, free": lambda: pendulum(c_g=0.0, horizon=1.0),
    "pendulum, free and fast": lambda: pendulum(c_g=0.0, theta_0=2.0, omega_0=-1.5),
    "tangential": lambda: pendulum_tangential(horizon=1.0),
    "damped": lambda: damped_pendulum(c_g=0.0, horizon=1.0),
    "damped and hot": lambda: damped_pendulum(c_g=0.0, gamma=0.3, kT=1.5, theta_0=2.0),
    "circle": circle,
    "velocity noise": lambda: pendulum_velocity_noise(sigma=0.4, omega_0=1.0, horizon=0.5),
    "velocity noise with friction": lambda: pendulum_velocity_noise(sigma=0.3, gamma=0.7, omega_0=1.5),
    "velocity noise, steady": lambda: pendulum_velocity_noise(sigma=0.4, gamma=0.08),
}
# Of one wrong rejection in the whole family, two-sided, for samples whose means are close to normal.
LEVEL = 1e-6
PATHS = 20_000


def moments(problem: Problem) -> dict[str, Moment]:
    return {truth.observable: truth for truth in problem.truths if isinstance(truth, Moment)}


def skew(problem: Problem, observable: str) -> bool:
    return observable == "x^3" and problem.source == "Kloeden & Platen 1992, (4.4.6)"


# The mean over a sample of a third power of a lognormal is far from normal: quadrature has that.
CASES = [(name, key) for name, make in PROBLEMS.items() for key in moments(make()) if not skew(make(), key)]
BOUND = float(-ndtri(LEVEL / (2 * 2 * len(CASES))))
# A deviation of so many standard errors is missed with a probability of 1e-4.
VISIBLE = BOUND + float(-ndtri(1e-4))


class Sample(NamedTuple):
    """Values of each observable on all paths, at half the horizon and at its end."""

    times: tuple[float, float]
    values: dict[str, tuple[Array, Array]]


def sample(name: str) -> Sample:
    problem = PROBLEMS[name]()
    truth, h = problem.pathwise, problem.horizon / 8
    assert truth is not None
    source = Source(5, name, 0, PATHS)
    extra, z, found, fine = source.stream("truth", 0), truth.start(PATHS), [], h / 4
    for n, levels in zip(range(8), brownian_steps(source, problem.noise_dim, h, 2), strict=False):
        for k in range(4):
            xi = extra.standard_normal((truth.extra_normals, PATHS)) if truth.extra_normals else None
            z = truth.advance(z, n * h + k * fine, fine, levels[2].increment(k)._replace(xi=xi))
        known = truth.parts((n + 1) * h, z)
        found.append({key: problem.observables[key]((n + 1) * h, known) for key in moments(problem)})
    return Sample((4 * h, 8 * h), {key: (found[3][key], found[7][key]) for key in found[0]})


@pytest.fixture(scope="module")
def samples() -> dict[str, Sample]:
    return {name: sample(name) for name in PROBLEMS}


def scores(drawn: Sample, moment: Moment, factor: float = 1.0) -> list[float]:
    """Return the difference of sample mean and expectation in standard errors, at both times."""
    pairs = zip(drawn.times, drawn.values[moment.observable], strict=True)
    return [(x.mean() - factor * moment.value(t)) / (x.std(ddof=1) / np.sqrt(PATHS) + 8 * EPS) for t, x in pairs]


@pytest.mark.parametrize(("name", "observable"), CASES)
def test_expectations_are_those_of_the_solution(samples: dict[str, Sample], name: str, observable: str) -> None:
    """The mean over paths of the solution agrees with the expectation."""
    for score in scores(samples[name], moments(PROBLEMS[name]())[observable]):
        assert abs(score) < BOUND


@pytest.mark.parametrize("name", PROBLEMS)
def test_expectations_wrong_by_a_twentieth_are_noticed(samples: dict[str, Sample], name: str) -> None:
    """Snapshot 5 % off are refuted wherever the sample can see 5 % of them, which is the case in each problem."""
    drawn, visible = samples[name], 0
    for observable, moment in moments(PROBLEMS[name]()).items():
        if (name, observable) not in CASES:
            continue
        planted = scores(drawn, moment, factor=1.05)
        for t, x, score in zip(drawn.times, drawn.values[observable], planted, strict=True):
            if 0.05 * abs(moment.value(t)) > VISIBLE * x.std(ddof=1) / np.sqrt(PATHS):
                visible += 1
                assert abs(score) > BOUND

    assert visible


TIMES = (0.0, 0.3, 1.0, 2.0)


def gaussian(theta_0: float, omega_0: float, t: float) -> tuple[Array, Array]:
    """Return mean and covariance of (theta, omega) for dtheta = omega dt, domega = dW.

    The covariance is int_0^t k k^T ds with the response k = (t - s, 1) to a kick at s, exact with two nodes.
    """
    nodes, weights = np.polynomial.legendre.leggauss(2)
    s = 0.5 * t * (1 + nodes)
    kicks = np.stack([t - s, np.ones(2)])
    return np.array([theta_0 + omega_0 * t, omega_0]), (kicks * 0.5 * t * weights) @ kicks.T


def expectation(f: Callable[[Array, Array], Array], theta_0: float, omega_0: float, t: float) -> float:
    """Return E f(theta(t), omega(t)) of the free pendulum."""
    return under(f, *gaussian(theta_0, omega_0, t))


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
@pytest.mark.parametrize("observable", GAUSSIAN)
@pytest.mark.parametrize("start", [(0.5, 0.5), (2.0, -1.5)])
def test_moments_of_the_free_pendulum_are_those_of_a_gaussian(
    noise: str, observable: str, start: tuple[float, float]
) -> None:
    """Snapshot of position and velocity agree with quadrature of the Gaussian law of angle and angular velocity."""
    moment = moments(FREE[noise](*start))[observable]
    for t in TIMES:
        value = expectation(GAUSSIAN[observable], *start, t)
        # 1600 positive weights that sum to one, of values up to about (1.5 + 9 sqrt 2)^4 weighted by their moments.
        assert moment.value(t) == pytest.approx(value, rel=1e-12, abs=1e-13)


def damped_law(gamma: float, sigma: float, t: float) -> tuple[Array, Array]:
    """Return mean and covariance of (theta, omega) for domega = -gamma omega dt + sigma dW from (0.5, 0.5).

    The response to a kick at s is ((1 - e^{-gamma u})/gamma, e^{-gamma u}) with u = t - s; Gauss quadrature.
    """
    nodes, weights = np.polynomial.legendre.leggauss(20)
    u = 0.5 * t * (1 + nodes)
    kicks = sigma * np.stack([-np.expm1(-gamma * u) / gamma, np.exp(-gamma * u)])
    mean = np.array([0.5 - 0.5 * np.expm1(-gamma * t) / gamma, 0.5 * np.exp(-gamma * t)])
    return mean, (kicks * 0.5 * t * weights) @ kicks.T


@pytest.mark.parametrize("observable", GAUSSIAN)
@pytest.mark.parametrize(("gamma", "kT"), [(1.0, 0.5), (0.3, 1.5)])
def test_moments_of_the_damped_pendulum_are_those_of_a_gaussian(observable: str, gamma: float, kT: float) -> None:
    """Without gravity, position and velocity have moments of the Gaussian law of angle and angular velocity."""
    moment = moments(damped_pendulum(c_g=0.0, gamma=gamma, kT=kT))[observable]
    for t in TIMES:
        law = damped_law(gamma, np.sqrt(2 * gamma * kT), t)
        assert moment.value(t) == pytest.approx(under(GAUSSIAN[observable], *law), rel=1e-12, abs=1e-13)


@pytest.mark.parametrize(("gamma", "kT"), [(1.0, 0.5), (0.3, 1.5)])
def test_the_multiplier_of_the_damped_pendulum_adds_up_its_speed(gamma: float, kT: float) -> None:
    """E mu is the time integral of E omega^2, Gauss quadrature with 20 nodes."""
    moment = moments(damped_pendulum(c_g=0.0, gamma=gamma, kT=kT))["mu"]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for t in TIMES:
        laws = [damped_law(gamma, np.sqrt(2 * gamma * kT), 0.5 * t * (1 + x)) for x in nodes]
        rates = [mean[1] ** 2 + covariance[1, 1] for mean, covariance in laws]
        assert moment.value(t) == pytest.approx(0.5 * t * float(weights @ rates), rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("power", [1, 2, 3])
@pytest.mark.parametrize(("a", "b"), [(0.5, 0.6), (2.0, 1.0), (-2.0, 1.0)])
def test_powers_of_geometric_brownian_motion_are_those_of_a_lognormal(a: float, b: float, power: int) -> None:
    """E x^n agrees with Gauss-Hermite quadrature over W(t)."""
    name = "x" if power == 1 else f"x^{power}"
    moment = moments(gbm(a=a, b=b, x_0=1.3))[name]
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    for t in TIMES[:3]:
        x = 1.3 * np.exp((a - 0.5 * b * b) * t + b * np.sqrt(t) * nodes)
        # Sixty positive terms, each an exponential whose argument, at most 40, is rounded.
        assert moment.value(t) == pytest.approx(weights @ x**power / np.sqrt(2 * np.pi), rel=240 * EPS)


@pytest.mark.parametrize("observable", ["x", "x^2", "x^3", "cos x"])
@pytest.mark.parametrize("a", [1.5, -0.8])
def test_moments_of_the_ornstein_uhlenbeck_process_are_those_of_a_normal_law(a: float, observable: str) -> None:
    """Expectations agree with Gauss-Hermite quadrature, mean and variance being solved from their equations."""
    problem = ou(a=a, sigma=0.6, x_0=0.7)
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    for t in TIMES[:3]:
        # m' = -a m, v' = -2 a v + sigma^2.
        variance = 0.36 * t * float(np.mean([np.exp(-2 * a * t * q) for q in MIDPOINTS])) if t else 0.0
        x = 0.7 * np.exp(-a * t) + np.sqrt(variance) * nodes
        value = weights @ problem.observables[observable](t, {"x": x[None]}) / np.sqrt(2 * np.pi)
        # The midpoint rule with 4096 points is off by (2 a t)^2/24/4096^2 of the variance.
        assert moments(problem)[observable].value(t) == pytest.approx(value, rel=1e-7)


MIDPOINTS = (np.arange(4096) + 0.5) / 4096


def multiplier_moments(omega_0: float, radial: float, t: float) -> tuple[float, float]:
    """Return E mu and E mu^2 for mu = int omega^2 dt + sqrt(radial) W', W' independent of the Gaussian omega.

    Cov(omega_s^2, omega_u^2) = 2 C^2 + 4 omega_0^2 C with C = Cov(omega_s, omega_u) = min(s, u) (Isserlis); the
    double integral is twice that over the triangle s < u, exact with four nodes a side.
    """
    nodes, weights = np.polynomial.legendre.leggauss(4)
    q, w = 0.5 + 0.5 * nodes, 0.5 * weights
    mean = t * float(w @ (omega_0**2 + t * q))
    u, s = t * q[:, None], t * q[:, None] * q[None]
    inner = 2 * s**2 + 4 * omega_0**2 * s
    variance = radial * t + 2 * float(np.sum(t * w[:, None] * u * w[None] * inner))
    return mean, mean**2 + variance


@pytest.mark.parametrize(("noise", "radial"), [("isotropic", 1.0), ("tangential", 0.0)])
@pytest.mark.parametrize("omega_0", [0.5, -1.5])
def test_moments_of_the_multiplier_are_those_of_a_gaussian(noise: str, radial: float, omega_0: float) -> None:
    """Mean and mean square of mu agree with integrals of the moments of a Gaussian angular velocity."""
    known = moments(FREE[noise](0.5, omega_0))
    for t in TIMES:
        mean, square = multiplier_moments(omega_0, radial, t)
        assert known["mu"].value(t) == pytest.approx(mean, rel=32 * EPS)
        assert known["mu^2"].value(t) == pytest.approx(square, rel=32 * EPS)


@pytest.mark.parametrize(("sigma", "gamma"), [(0.5, 0.0), (0.3, 0.7), (1.0, 0.5), (0.4, 0.08)])
def test_moments_with_velocity_noise_are_those_of_a_lognormal(sigma: float, gamma: float) -> None:
    """Snapshot of |v| agree with quadrature over W(t), and E mu with that of its rate E |v|^2 over time."""
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


@pytest.mark.parametrize("make", [lambda: pendulum(c_g=0.0), pendulum_tangential], ids=["isotropic", "tangential"])
def test_the_free_pendulum_gains_half_a_unit_of_energy(make: Callable[[], HolonomicSDAE]) -> None:
    """Energy balance and E |v|^2 = omega_0^2 + t say the same where there is no potential."""
    known = moments(make())
    for t in TIMES:
        assert known["|v|^2"].value(t) == pytest.approx(2 * known["energy"].value(t), rel=8 * EPS)


STABILITY: dict[str, tuple[Callable[[], Problem], str]] = {
    "gbm, growing": (gbm, "x^2"),
    "gbm, pathwise stable only": (lambda: gbm(a=-0.1, b=0.6), "x^2"),
    "gbm, stable": (lambda: gbm(a=-0.2, b=0.6), "x^2"),
    "ou": (ou, "x^2"),
    "ou, growing": (lambda: ou(a=-0.5), "x^2"),
    "ou without noise": (lambda: ou(sigma=0.0), "x^2"),
    "ou without noise, growing": (lambda: ou(a=-0.5, sigma=0.0), "x^2"),
    "linear test": (linear_test, "x^2"),
    "linear test, not stable": (lambda: linear_test(b=2.1), "x^2"),
    "velocity noise": (pendulum_velocity_noise, "|v|^2"),
    "velocity noise, damped": (lambda: pendulum_velocity_noise(sigma=0.5, gamma=0.15), "|v|^2"),
    "velocity noise, not enough damped": (lambda: pendulum_velocity_noise(sigma=0.5, gamma=0.1), "|v|^2"),
}


@pytest.mark.parametrize("name", STABILITY)
def test_mean_square_stability_is_that_of_the_second_moment(name: str) -> None:
    """A problem says it is mean-square stable exactly if its known second moment tends to zero."""
    make, observable = STABILITY[name]
    problem = make()
    (truth,) = [truth for truth in problem.truths if isinstance(truth, MeanSquareStability)]
    second = moments(problem)[observable]

    assert truth.stable == (second.value(300.0) < 1e-3 * second.value(0.0))
