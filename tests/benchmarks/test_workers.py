"""Two worker processes against one."""

from functools import partial
from time import perf_counter

import pytest

import sdaeverify
from benchmarks.pairs import run_pairs
from facade import available_cores
from sdaeverify import Settings

pytestmark = pytest.mark.benchmark

SECONDS = 20.0
STUDY = partial(
    sdaeverify.verify, "half-explicit-euler[truncation=none]", "pendulum", ["strong", "drift"], max_looks=1
)


def test_two_workers_against_one(benchmark, report):
    """Two workers, their start included, nearly halve a run of about 20 seconds."""
    if available_cores() < 2:
        pytest.skip("needs two cores")
    paths = _paths_for(SECONDS)
    pairs = run_pairs(benchmark, lambda: STUDY(paths=paths, jobs=2), lambda: STUDY(paths=paths, jobs=1), rounds=3)
    what = f"{paths} paths, {min(pairs.other):.0f} s with one worker, one / two workers"
    report(what, pairs.speed_up, "at least 1.7")


def _paths_for(seconds: float) -> int:
    block = Settings().block
    STUDY(paths=block)
    begun = perf_counter()
    STUDY(paths=4 * block)
    return block * round(4 * seconds / (perf_counter() - begun))
