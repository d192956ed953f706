"""The published intervals contain the true slope as often as they say."""

from typing import NamedTuple

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


class Coverage(NamedTuple):
    """How often intervals contain the slope: Student's interval of the jackknife, and as published."""

    jackknife: float
    published: float


def coverage(scheme_label, problem_label, repetitions):
    """Return, for each quantity, how often a 95 % interval from 400 paths contains the slope from all paths.

    Each block of paths is a repetition; the slope of all of them together stands for the true one. The published
    interval is wider than the jackknife's by the bound of the reference's bias.
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
    return {name: Coverage(*rates([one[name] for one in single], slope)) for name, slope in truth.items()}


def rates(findings, slope):
    for share in (1.0, 0.0):
        narrowed = [share * finding.details["bias_bound"] for finding in findings]
        yield np.mean([f.low + n <= slope <= f.high - n for f, n in zip(findings, narrowed, strict=True)])


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "problem"), CASES)
def test_coverage_of_the_slope_interval(scheme, problem, capsys):
    """Over 1000 repetitions, 95 % intervals of the L1 slope from 400 paths cover 93 to 97 per cent."""
    covered = coverage(scheme, problem, 1000)

    with capsys.disabled():
        print(f"\n{scheme} on {problem}, jackknife interval and as published with the reference's bias:")
        for name, found in covered.items():
            print(f"  {name:8} {found.jackknife:.3f} {found.published:.3f}")
    assert all(0.93 <= found.jackknife <= 0.97 for found in covered.values())
    assert all(found.published >= found.jackknife for found in covered.values())


def test_coverage_in_a_quick_sample():
    """Over 100 repetitions on gbm, the coverage is what a nominal 95 % allows at a level of 1e-4."""
    repetitions = 100

    rate = coverage("euler-maruyama", "gbm", repetitions)["x"].published

    low, high = binom.ppf([5e-5, 1 - 5e-5], repetitions, 0.95) / repetitions
    assert low <= rate <= high
