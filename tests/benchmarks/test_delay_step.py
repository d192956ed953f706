"""The time of a step with a delay against one with another delay, and of an exact decision on stability."""

from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.pairs import run_pairs
from facade import StochasticTheta, Track, delay_test, probe_step
from probe.theta_cells import is_stable
from sdaeverify.studying import LevelNoise, Source

pytestmark = pytest.mark.benchmark

PATHS, STEPS, PAIRS = 500, 64, 31
SHORT, LONG = 8, 512


def steps(m: int, theta: float) -> Callable[[], object]:
    """Return some steps of a run whose delay is m steps long, the lagged values among them."""
    problem, h = delay_test("II"), 1.0 / m
    dW = np.sqrt(h) * Source(1, "benchmark", 0, PATHS).stream("brownian", 0).standard_normal((STEPS, 1, PATHS))
    track = Track(StochasticTheta(theta=theta), problem, 0, h, PATHS)
    return lambda: track.advance(LevelNoise(dW, None), ())


@pytest.mark.parametrize("theta", [0.0, 1.0])
def test_a_step_costs_the_same_whatever_the_delay(theta, benchmark, report, one_core):
    """A ring of the last states is written and read at one place a step."""
    cost = run_pairs(benchmark, steps(LONG, theta), steps(SHORT, theta), PAIRS).cost
    report(f"stochastic-theta[theta={theta:g}], a delay of {LONG} steps / of {SHORT}", cost, "1: flat in m")


@pytest.mark.parametrize("m", [16, 64, 1024])
def test_a_decision_on_stability_against_simulating_it(m, benchmark, report, one_core):
    """What is exact costs less than the paper's averages: 1000 paths of set II over 20 delays, theta = 0.2."""
    problem, h, scheme = delay_test("II"), 1.0 / m, StochasticTheta(theta=0.2)
    dW = np.sqrt(h) * Source(1, "benchmark", 0, 1000).stream("brownian", 0).standard_normal((16, 1, 1000))

    def decide() -> object:
        return is_stable(probe_step(scheme, problem, h).step, problem.mesh(h))

    def sixteen_steps() -> object:
        track = Track(scheme, problem, 0, h, 1000)
        track.advance(LevelNoise(dW, None), ())
        return track

    ratio = run_pairs(benchmark, decide, sixteen_steps, 7).cost
    report(f"exact decision with m = {m} / 16 of the {20 * m} steps of 1000 paths", ratio, f"below {20 * m / 16:g}")
