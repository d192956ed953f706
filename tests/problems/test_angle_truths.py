"""The pendulums' solutions in angle form, against an independent scheme on finely refined noise."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import pytest

from facade import _circle as circle
from facade import damped_pendulum, pendulum, pendulum_tangential
from sdaeverify import Array, HolonomicSDAE, Increment
from sdaeverify.measuring import Estimate, group_sums, jackknife
from sdaeverify.numerics import log_norms, slope_weights
from sdaeverify.probing import LevelNoise, Source, brownian_steps
from sdaeverify_problems.pendulums import pendulum_velocity_noise as velocity_noise

PATHS, COARSEST, LEVELS, DEPTH, HORIZON = 240, 4, 4, 10, 0.5
# Halfway between order 3/2 and order 1, which is what any one missing term of the step would leave.
BETWEEN = 1.25
CONFIDENCE = 0.999
ROWS = {"theta": 0, "omega": 1, "mu": 2}

Advance = Callable[[Array, float, float, Increment], Array]


class Case(NamedTuple):
    """A pendulum, and its angle form dz = f(z) dt + b(z, o dW) in Stratonovich's sense."""

    problem: HolonomicSDAE
    drift: Callable[[Array], Array]
    noise: Callable[[Array, Array], Array]
    exact: tuple[str, ...] = ()


def gravity(c_g: float) -> Case:
    def drift(z: Array) -> Array:
        return np.stack([z[1], -c_g * np.sin(z[0]), c_g * np.cos(z[0]) + z[1] ** 2])

    def noise(z: Array, dW: Array) -> Array:
        c, s = np.cos(z[0]), np.sin(z[0])
        return np.stack([0.0 * c, c * dW[0] + s * dW[1], s * dW[0] - c * dW[1]])

    return Case(pendulum(c_g=c_g, horizon=HORIZON), drift, noise)


def damped(gamma: float, kT: float) -> Case:
    sigma, free = np.sqrt(2 * gamma * kT), gravity(1.0)

    def drift(z: Array) -> Array:
        return free.drift(z) - np.stack([0.0 * z[0], gamma * z[1], 0.0 * z[0]])

    problem = damped_pendulum(gamma=gamma, kT=kT, horizon=HORIZON)
    return Case(problem, drift, lambda z, dW: sigma * free.noise(z, dW))


def tangential() -> Case:
    def drift(z: Array) -> Array:
        return np.stack([z[1], 0.0 * z[1], z[1] ** 2])

    def noise(z: Array, dW: Array) -> Array:
        return np.stack([0.0 * dW[0], dW[0], 0.0 * dW[0]])

    return Case(pendulum_tangential(horizon=HORIZON), drift, noise, ("theta", "omega"))


def proportional(sigma: float, gamma: float) -> Case:
    def drift(z: Array) -> Array:
        return np.stack([z[1], -(gamma + 0.5 * sigma**2) * z[1], z[1] ** 2])

    def noise(z: Array, dW: Array) -> Array:
        return np.stack([0.0 * z[1], sigma * z[1] * dW[0], 0.0 * z[1]])

    problem = velocity_noise.pendulum_velocity_noise(sigma=sigma, gamma=gamma, horizon=HORIZON)
    return Case(problem, drift, noise, ("omega",))


CASES: dict[str, Callable[[], Case]] = {
    "c_g=1": lambda: gravity(1.0),
    "c_g=0": lambda: gravity(0.0),
    "damped": lambda: damped(1.0, 0.5),
    "tangential": tangential,
    "sigma=0.6": lambda: proportional(0.6, 0.0),
    "sigma=0.3,gamma=0.7": lambda: proportional(0.3, 0.7),
}


def without_turning_noise(z: Array, h: float, noise: Increment) -> Array:
    """Return the term -omega <r, J> of omega."""
    J = h * noise.dW - noise.time_integral(h)
    return np.stack([0.0 * z[0], -z[1] * (circle.normal(z[0]) * J).sum(axis=0), 0.0 * z[0]])


def without_square_of_tangential_noise(z: Array, h: float, noise: Increment) -> Array:
    """Return the term h^2/2 of mu."""
    return np.stack([0.0 * z[0], 0.0 * z[0], np.full_like(z[0], 0.5 * h**2)])


def without_friction_of_noise(z: Array, h: float, noise: Increment) -> Array:
    """Return the term -gamma sigma <t, I> of omega, gamma = sigma = 1."""
    integral = (circle.tangent(z[0]) * noise.time_integral(h)).sum(axis=0)
    return np.stack([0.0 * z[0], -integral, 0.0 * z[0]])


def without_rest_of_square(z: Array, h: float, noise: Increment) -> Array:
    """Return the term h^2/15 of mu."""
    return np.stack([0.0 * z[0], 0.0 * z[0], np.full_like(z[0], h**2 / 15)])


def without_square(z: Array, h: float, noise: Increment) -> Array:
    """Return the terms with int W^2 of theta and mu, sigma = 0.6."""
    square = 0.6**2 * circle.square_integral(h, noise)[0]
    return np.stack([0.5 * z[1] * square, 0.0 * z[0], 2.0 * z[1] ** 2 * square])


# What is left out, and the rows where that shows.
PLANTED: dict[str, tuple[str, Callable[[Array, float, Increment], Array], tuple[str, ...]]] = {
    "turning noise, c_g=1": ("c_g=1", without_turning_noise, ("omega",)),
    "turning noise, c_g=0": ("c_g=0", without_turning_noise, ("omega",)),
    "square of noise, c_g=1": ("c_g=1", without_square_of_tangential_noise, ("mu",)),
    "square of noise, c_g=0": ("c_g=0", without_square_of_tangential_noise, ("mu",)),
    "friction of noise": ("damped", without_friction_of_noise, ("omega",)),
    "turning noise, damped": ("damped", without_turning_noise, ("omega",)),
    "square of noise, damped": ("damped", without_square_of_tangential_noise, ("mu",)),
    "rest of the square": ("tangential", without_rest_of_square, ("mu",)),
    "square": ("sigma=0.6", without_square, ("theta", "mu")),
}


def lacking(advance: Advance, term: Callable[[Array, float, Increment], Array]) -> Advance:
    return lambda z, t, h, noise: advance(z, t, h, noise) - term(z, h, noise)


def heun(case: Case, z: Array, h: float, noise: LevelNoise) -> Array:
    """Make all steps of one level by the trapezoidal rule with a predictor, from the increments dW alone."""
    for dW in noise.dW:
        f, b = case.drift(z), case.noise(z, dW)
        guess = z + h * f + b
        z = z + 0.5 * (h * (f + case.drift(guess)) + b + case.noise(guess, dW))
    return z


def errors(case: Case, solutions: Mapping[str, Advance]) -> dict[str, Array]:
    """Return the errors of solutions at the end, shape (level, row, path), the finest scheme being the truth."""
    truth, h = case.problem.pathwise, HORIZON / COARSEST
    assert truth is not None
    fine = truth.start(PATHS)
    tracks = {name: [truth.start(PATHS)] * LEVELS for name in solutions}
    source = Source(11, "angle", 0, PATHS)
    steps = zip(range(COARSEST), brownian_steps(source, case.problem.noise_dim, h, DEPTH), strict=False)
    for n, levels in steps:
        fine = heun(case, fine, h / 2**DEPTH, levels[DEPTH])
        for name, advance in solutions.items():
            for level in range(LEVELS):
                for k in range(2**level):
                    length, noise = h / 2**level, levels[level].increment(k)
                    tracks[name][level] = advance(tracks[name][level], n * h + k * length, length, noise)
    return {name: np.abs(np.stack(track) - fine) for name, track in tracks.items()}


def order(distances: Array) -> Estimate:
    """Return the order in the mean of distances of shape (level, path)."""
    weights = -slope_weights(np.arange(LEVELS, dtype=float))
    counts = group_sums(np.ones(PATHS))
    return jackknife(group_sums(distances), counts, lambda means: float(weights @ log_norms(means, 1.0)))


@pytest.fixture(scope="module")
def orders() -> dict[str, dict[str, Estimate]]:
    """Return the order of each case and of each planted fault, row by row."""
    found: dict[str, Array] = {}
    for name, make in CASES.items():
        case = make()
        assert case.problem.pathwise is not None
        advance = case.problem.pathwise.advance
        faulty = {fault: lacking(advance, term) for fault, (where, term, _) in PLANTED.items() if where == name}
        found |= errors(case, {name: advance, **faulty})
    return {name: {row: order(e[:, i]) for row, i in ROWS.items()} for name, e in found.items()}


@pytest.mark.parametrize("name", CASES)
def test_angle_solutions_converge_at_order_three_halves(orders: dict[str, dict[str, Estimate]], name: str) -> None:
    """What is not exact approaches the solution of the angle form nearer to order 3/2 than to order 1."""
    for row in ROWS.keys() - set(CASES[name]().exact):
        assert orders[name][row].interval(CONFIDENCE)[0] > BETWEEN, (row, orders[name][row])
