"""Large cells: cost in proportion to paths and to steps, memory that knows neither."""

from functools import partial

import pytest

import sdaeverify
from benchmarks.pairs import run_pairs
from benchmarks.test_memory import LIMIT, peak_megabytes

pytestmark = pytest.mark.benchmark

# Laurent (2022), Figure 1: a cell that a cluster runs with 10^7 paths, block by block.
TORUS = partial(sdaeverify.verify, "uniformly-accurate", "torus", "weak", max_looks=1, levels=3)
STEPS = partial(
    sdaeverify.verify, "half-explicit-euler[truncation=none]", "pendulum", "drift", max_looks=1, paths=4096
)
BLOCK, TIMES = 4096, 4


def test_cost_of_many_paths(benchmark, report, one_core):
    """Four times as many blocks of paths of the torus cost four times as much, beyond what is found without paths."""
    begin, few, many = (partial(TORUS, paths=BLOCK * blocks) for blocks in (1, 2, 1 + TIMES))
    first = run_pairs(benchmark, few, begin, rounds=3)
    rest = run_pairs(_Silent, many, begin, rounds=3)
    grown = (min(rest.ours) - min(rest.other)) / (min(first.ours) - min(first.other))
    report(f"torus, {TIMES} further blocks / one, per block", grown / TIMES, "at most 1.1")


def test_cost_of_many_steps(benchmark, report, one_core):
    """Eight times as many steps cost about eight times as much."""
    pairs = run_pairs(benchmark, partial(STEPS, levels=8), partial(STEPS, levels=5), rounds=3)
    steps = (2**8 - 1) / (2**5 - 1)
    report(f"pendulum, {steps:.1f} times the steps, cost per step", pairs.cost / steps, "at most 1.1")


@pytest.mark.parametrize("paths", [10**4, 10**5, 10**6])
def test_memory_of_a_cell_of_the_torus(paths, benchmark, report):
    """The peak is that of a block, for 10^4 paths as for 10^6: 10^7 take ten times as long and no more memory."""
    arguments = f"'uniformly-accurate', 'torus', 'weak', paths={paths}, max_looks=1, levels=3, coarsest=2"
    peak = benchmark.pedantic(peak_megabytes, args=(arguments,), rounds=1)
    report(f"torus, {paths} paths, peak in MB", peak, "below 500")
    assert peak < LIMIT


class _Silent:
    """Runs pairs beside those that the table of benchmarks is about."""

    @staticmethod
    def pedantic(task, setup, rounds):
        """Run them."""
        for _ in range(rounds):
            setup()
            task()
