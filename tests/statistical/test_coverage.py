"""The published intervals contain the true slope as often as they say."""

import numpy as np
import pytest
from scipy.stats import binom

from sdaeverify import Settings
from sdaeverify.ensemble import Entry, Task, run_block
from sdaeverify.matching import match
from sdaeverify.measure import Evidence
from sdaeverify.registry import load_registry
from sdaeverify.selection import select_measures, select_problems, select_schemes

PATHS = 400
CASES = [("euler-maruyama", "gbm"), ("half-explicit-euler[truncation=none]", "pendulum")]


def coverage(scheme_label, problem_label, repetitions):
    """Return, for each quantity, how often a 95 % interval from 400 paths contains the slope from all paths.

    Each block of paths is a repetition; the slope of all of them together stands for the true one.
    """
    settings = Settings(paths=PATHS * repetitions, block=PATHS, confidence=0.95)
    registry = load_registry()
    (scheme,), (spec,) = select_schemes(registry, [scheme_label]), select_problems(registry, [problem_label])
    (strong,) = select_measures(registry, ["strong"])
    problem = spec.build()
    view = match(scheme, problem).problem
    task = Task(spec, (Entry(scheme, (strong,)),), settings)

    def findings(lane, paths):
        chosen = Settings(paths=paths, block=PATHS, confidence=0.95)
        judged = strong.judge(Evidence(scheme, problem, view, chosen, lane.tallies[0], lane.health))
        return {finding.quantity: finding for finding in judged.findings}

    lanes = [run_block(task, block)[0] for block in range(repetitions)]
    pooled = lanes[0]
    for lane in lanes[1:]:
        pooled = pooled.merged(lane)
    truth = {name: finding.estimate for name, finding in findings(pooled, PATHS * repetitions).items()}
    single = [findings(lane, PATHS) for lane in lanes]
    return {
        name: np.mean([one[name].low <= slope <= one[name].high for one in single])
        for name, slope in truth.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "problem"), CASES)
def test_coverage_of_the_slope_interval(scheme, problem, capsys):
    """Over 1000 repetitions, 95 % intervals of the L1 slope from 400 paths cover 93 to 97 per cent."""
    covered = coverage(scheme, problem, 1000)

    with capsys.disabled():
        print(
            f"\n{scheme} on {problem}: " + ", ".join(f"{name} {rate:.3f}" for name, rate in covered.items())
        )
    assert all(0.93 <= rate <= 0.97 for rate in covered.values())


def test_coverage_in_a_quick_sample():
    """Over 100 repetitions on gbm, the coverage is what a nominal 95 % allows at a level of 1e-4."""
    repetitions = 100

    (rate,) = {coverage("euler-maruyama", "gbm", repetitions)["x"]}

    low, high = binom.ppf([5e-5, 1 - 5e-5], repetitions, 0.95) / repetitions
    assert low <= rate <= high
