"""Solutions on curves and fine references of order 3/2, against schemes that share no formula with them."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from facade import SRA1, angle_pendulum, circle, double_well, ellipse
from sdaeverify import SDE, Array, Increment, Pathwise, Problem, Scheme
from sdaeverify.measuring import Estimate, group_sums, jackknife
from sdaeverify.numerics import log_norms, slope_weights
from sdaeverify.probing import LevelNoise, Source, brownian_steps

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


ADDITIVE: dict[str, Callable[[], Problem]] = {"double well": double_well, "angle pendulum": angle_pendulum}


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
