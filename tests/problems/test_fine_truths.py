"""Solutions on curves and fine references of order 3/2, against schemes that share no formula with them."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from joined_noise import aggregate
from sdaeverify import SDE, Increment, Pathwise
from sdaeverify.arrays import Array
from sdaeverify.contracts.scheme import Scheme
from sdaeverify.forms import Problem
from sdaeverify.noise.brownian import LevelNoise, Source, brownian_steps
from sdaeverify.numerics.statistics import Estimate, group_sums, jackknife, log_norms, slope_weights
from sdaeverify_problems import _arc_length as arc_length
from sdaeverify_problems.angle_pendulum import angle_pendulum
from sdaeverify_problems.circle import circle
from sdaeverify_problems.double_well import double_well
from sdaeverify_problems.ellipse import ellipse
from sdaeverify_schemes.heun import Heun
from sdaeverify_schemes.sra1 import SRA1

EPS = np.finfo(float).eps
PATHS, COARSEST, LEVELS, DEPTH, HORIZON = 240, 4, 4, 8, 0.5
# Halfway between the order of a right solution and the next lower one, or none.
BETWEEN_SCHEMES, BETWEEN_TERMS, CONFIDENCE = 0.5, 1.25, 0.999

Advance = Callable[[Array, float, float, Increment], Array]


def truth_of(problem: Problem) -> Pathwise:
    assert problem.pathwise is not None
    return problem.pathwise


@cache
def noises(name: str) -> list[LevelNoise]:
    """Return the noise of the whole horizon at levels 0 to DEPTH, one array each."""
    source = Source(12, name, 0, PATHS)
    levels = next(brownian_steps(source, 1, HORIZON, DEPTH + 2))
    return list(levels[2:])


def run(advance: Advance, z: Array, noise: LevelNoise) -> Array:
    h = HORIZON / len(noise.dW)
    for n in range(len(noise.dW)):
        z = advance(z, n * h, h, noise.increment(n))
    return z


def by_scheme(scheme: Scheme, problem: Problem, noise: LevelNoise) -> Array:
    """Return the final state of a scheme in one array."""
    view = problem.view(SDE)
    assert view is not None

    def advance(x: Array, t: float, h: float, increment: Increment) -> Array:
        return np.asarray(scheme.step(view, x, t, h, increment).state)

    return run(advance, problem.initial(PATHS), noise)


def by_truth(problem: Problem, advance: Advance, noise: LevelNoise) -> Array:
    """Return the final state of a solution in one array."""
    truth = truth_of(problem)
    parts = truth.parts(HORIZON, run(advance, truth.start(PATHS), noise))
    return np.concatenate(list(parts.values()))


def order(errors: list[Array]) -> Estimate:
    """Return the order in the mean of distances (d, P), one array a level, halving steps."""
    distances = np.stack([np.linalg.norm(error, axis=0) for error in errors])
    weights = -slope_weights(np.arange(len(errors), dtype=float))
    sums, counts = group_sums(distances), group_sums(np.ones(PATHS))
    return jackknife(sums, counts, lambda means: float(weights @ log_norms(means, 1.0)))


CURVES: dict[str, Callable[[], Problem]] = {
    "circle": circle,
    "ellipse, arc": ellipse,
    "ellipse, delta": lambda: ellipse("delta"),
}
SWAPPED = {"ellipse, arc": "ellipse, delta", "ellipse, delta": "ellipse, arc"}


def approach(name: str, solution: str) -> Estimate:
    """Return the order at which Heun's scheme in the plane approaches a solution by arc length."""
    problem, levels = CURVES[name](), noises("curve")
    known = CURVES[solution]()
    final = by_truth(known, truth_of(known).advance, levels[DEPTH])
    return order([by_scheme(Heun(), problem, levels[k]) - final for k in range(2, 2 + LEVELS)])


@pytest.mark.parametrize("name", CURVES)
def test_a_scheme_in_the_plane_approaches_the_solution_on_the_curve(name: str) -> None:
    """Heun's scheme knows drift and diffusion alone, and converges to the solution in the angle."""
    assert approach(name, name).interval(CONFIDENCE)[0] > BETWEEN_SCHEMES


@pytest.mark.parametrize("name", SWAPPED)
def test_a_scheme_does_not_approach_the_solution_for_another_measure(name: str) -> None:
    """Arc length and delta(g) differ by their drifts: the error stays as it is."""
    assert approach(name, SWAPPED[name]).interval(CONFIDENCE)[1] < BETWEEN_SCHEMES


ADDITIVE: dict[str, Callable[[], Problem]] = {"double well": double_well, "angle pendulum": angle_pendulum}


def arc_term(z: Array, h: float, noise: Increment) -> Array:
    """Return the part of the step of the arc length that the second derivative of its drift makes."""
    theta = arc_length.angle(z)
    bend = np.imag(arc_length.slope(theta + 1e-100j)) / 1e-100 / arc_length.speed(theta)
    first = arc_length.drift(theta) * arc_length.slope(theta)
    return 0.5 * h * h * (first + 0.5 * bend)


# Terms of size h^(3/2), or h^2 with a mean, without which the order is 1.
PLANTED: dict[str, tuple[str, Callable[[Array, float, Increment], Array]]] = {
    "well, noise in the drift": ("double well", lambda z, h, n: (1 - 3 * z * z) * n.time_integral(h)),
    "well, bend of the drift": ("double well", lambda z, h, n: -1.5 * h * h * z),
    "pendulum, noise in the friction": (
        "angle pendulum",
        lambda z, h, n: np.concatenate([0.0 * z[:1], -0.35 * n.time_integral(h)]),
    ),
    "pendulum, noise in the angle": (
        "angle pendulum",
        lambda z, h, n: np.concatenate([0.7 * n.time_integral(h), 0.0 * z[:1]]),
    ),
    "arc length, noise in the drift": (
        "ellipse, delta",
        lambda z, h, n: arc_length.slope(arc_length.angle(z)) * n.time_integral(h),
    ),
    "arc length, bend of the drift": ("ellipse, delta", arc_term),
}


@cache
def finest(name: str) -> Array:
    """Return the ends that a fine reference is compared with.

    With additive noise those of a Runge-Kutta scheme of order 3/2; on the ellipse its own on the finest noise.
    """
    if name in ADDITIVE:
        return by_scheme(SRA1(), ADDITIVE[name](), noises("taylor")[DEPTH])
    problem = CURVES[name]()
    return by_truth(problem, truth_of(problem).advance, noises("taylor")[DEPTH])


def own_order(name: str, term: Callable[[Array, float, Increment], Array] | None = None) -> Estimate:
    """Return the order of a fine reference, with or without one of its terms."""
    problem, levels = {**ADDITIVE, **CURVES}[name](), noises("taylor")
    right = truth_of(problem).advance

    def lacking(z: Array, t: float, h: float, noise: Increment) -> Array:
        return right(z, t, h, noise) - (term(z, h, noise) if term else 0.0)

    return order([by_truth(problem, lacking, levels[k]) - finest(name) for k in range(LEVELS)])


@pytest.mark.parametrize("name", [*ADDITIVE, "ellipse, delta"])
def test_fine_references_converge_at_order_three_halves(name: str) -> None:
    """The Ito-Taylor steps are nearer to order 3/2 than to order 1."""
    assert own_order(name).interval(CONFIDENCE)[0] > BETWEEN_TERMS


@pytest.mark.parametrize("fault", PLANTED)
def test_a_missing_term_of_a_fine_reference_is_noticed(fault: str) -> None:
    """A step that lacks one term is of order 1."""
    assert own_order(*PLANTED[fault]).interval(CONFIDENCE)[1] < BETWEEN_TERMS


@pytest.mark.parametrize("name", ["circle", "ellipse, arc"])
def test_solutions_on_curves_compose(name: str) -> None:
    """Two steps on refined noise are one step on the joined noise."""
    truth, fine = truth_of(CURVES[name]()), noises("compose")[0]
    once = run(truth.advance, truth.start(PATHS), aggregate(fine))

    assert np.abs(once - run(truth.advance, truth.start(PATHS), fine)).max() <= 16 * EPS * (1.0 + np.abs(once).max())


def test_the_angle_is_the_inverse_of_the_arc_length() -> None:
    """Arc lengths of angles over two turns are those of a quadrature of |dX/dtheta|, and angles come back."""
    theta = np.linspace(-6.5, 6.5, 41)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    points = 0.5 * theta[:, None] * (1.0 + nodes)
    lengths = 0.5 * theta * (np.hypot(2.0 * np.sin(points), np.cos(points)) @ weights)

    assert np.abs(arc_length.angle(lengths) - theta).max() <= 1e-13
    assert np.abs(arc_length.speed(theta) - np.hypot(2.0 * np.sin(theta), np.cos(theta))).max() <= 8 * EPS


def test_the_drift_of_the_arc_length_is_that_of_the_density() -> None:
    """Beta = (1/2) d log(1/l)/ds, and `slope` is its derivative by s."""
    theta = np.linspace(-3.0, 3.0, 41)
    log = np.imag(np.log(arc_length.speed(theta + 1e-100j))) / 1e-100 / arc_length.speed(theta)
    turning = np.imag(arc_length.drift(theta + 1e-100j)) / 1e-100 / arc_length.speed(theta)

    assert np.abs(arc_length.drift(theta) + 0.5 * log).max() <= 16 * EPS
    assert np.abs(arc_length.slope(theta) - turning).max() <= 32 * EPS
