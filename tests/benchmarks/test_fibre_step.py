"""The time of a step of the clamped fibre: against drawing its noise, another scheme, and a shorter fibre."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from benchmarks.pairs import run_pairs
from facade import (
    ExplicitProjectionEuler,
    HalfExplicitEuler,
    ImplicitEulerGGL,
    SemiImplicitProjectionEuler,
    fibre_clamped,
)
from sdaeverify import Increment, Scheme
from sdaeverify.studying import Source

pytestmark = pytest.mark.benchmark

SHORT, LONG, STEPS, PATHS, PAIRS = 20, 160, 15, 500, 61
SEMI_IMPLICIT = SemiImplicitProjectionEuler()
SCHEMES = [
    HalfExplicitEuler(truncation="none"),
    ExplicitProjectionEuler(),
    SEMI_IMPLICIT,
    SemiImplicitProjectionEuler("new"),
    ImplicitEulerGGL(),
]


@cache
def step(scheme: Scheme, N: int) -> Callable[[], object]:
    """Return one step of a fibre of N points in the plane, from where some semi-implicit steps have led.

    The step size is ds^2/100, as in Fig. 4.1 of Lindner et al. (2018).
    """
    h = 0.01 / (N + 1) ** 2
    problem = fibre_clamped(alpha=4.0, N=N, horizon=STEPS * h)
    stream = Source(1, "benchmark", 0, PATHS).stream("brownian", 0)
    dW = np.sqrt(h) * stream.standard_normal((STEPS + 1, problem.noise_dim, PATHS))
    state, before = problem.initial(PATHS), SEMI_IMPLICIT.prepare(problem, h)
    for n in range(STEPS):
        state = before(state, n * h, Increment(dW[n], None)).state
    stepper, begin = scheme.prepare(problem, h), scheme.enter(problem, state, 0.0, h)
    return lambda: stepper(begin, 0.0, Increment(dW[-1], None))


def test_semi_implicit_step_against_drawing_its_normals(benchmark, report, one_core):
    """A semi-implicit step of 20 points in the plane costs a few draws of its 40 normals a path."""
    stream = Source(1, "benchmark", 1, PATHS).stream("brownian", 0)

    cost = run_pairs(
        benchmark, step(SEMI_IMPLICIT, SHORT), lambda: stream.standard_normal((2 * SHORT, PATHS)), PAIRS
    ).cost
    report(f"{SEMI_IMPLICIT.label} on {SHORT} points, step / draw of 40 normals a path", cost, "at most 8")


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.label)
def test_a_step_grows_like_the_number_of_points(scheme, benchmark, report, one_core):
    """A step of eight times as many points costs about eight times as much, whatever the scheme."""
    growth = run_pairs(benchmark, step(scheme, LONG), step(scheme, SHORT), PAIRS // 3).cost
    report(f"{scheme.label}, step of {LONG} points / step of {SHORT}", growth, "at most 10")


@pytest.mark.parametrize(("scheme", "goal"), [(SCHEMES[-1], "at most 60"), (SCHEMES[1], "about 1")], ids=str)
def test_a_step_against_a_semi_implicit_one(scheme, goal, benchmark, report, one_core):
    """Newton's method on all unknowns costs tens of projections."""
    cost = run_pairs(benchmark, step(scheme, SHORT), step(SEMI_IMPLICIT, SHORT), PAIRS).cost
    report(f"{scheme.label} on {SHORT} points, step / semi-implicit step", cost, goal)
