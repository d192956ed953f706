"""The time of a half-explicit step in units of drawing its noise."""

import numpy as np
import pytest

from benchmarks.pairs import run_pairs
from facade import HalfExplicitEuler, pendulum
from sdaeverify import Increment
from sdaeverify.studying import Source

pytestmark = pytest.mark.benchmark

STEPS, SIZES = 64, (2048, 4096, 8192)
PAIRS = 61


@pytest.mark.parametrize("paths", SIZES)
@pytest.mark.parametrize("truncation", ["none", "theory"])
def test_half_explicit_step_against_drawing_its_normals(truncation, paths, benchmark, report, one_core):
    """A generic half-explicit step on the pendulum costs a few draws of its two normals a path."""
    problem, scheme = pendulum(), HalfExplicitEuler(truncation=truncation)
    h = problem.horizon / STEPS
    stream = Source(1, "benchmark", 0, paths).stream("brownian", 0)
    dW = np.sqrt(h) * stream.standard_normal((STEPS, 2, paths))
    stepper = scheme.prepare(problem, h)

    def steps() -> None:
        state = scheme.start(problem, paths, h)
        for step in range(STEPS):
            state = stepper(state, step * h, Increment(dW[step], dW[step])).state

    def draws() -> None:
        for _ in range(STEPS):
            stream.standard_normal((2, paths))

    ratio = run_pairs(benchmark, steps, draws, PAIRS).cost
    goal = "at most 2.5" if paths >= 8192 else "at most 4"
    report(f"{scheme.label} on {paths} paths, step / draw of two normals a path", ratio, goal)
