"""Local orders by probing against the order of the same scheme along paths."""

import pytest

from benchmarks.pairs import run_pairs
from benchmarks.study import ours
from sdaeverify.probe.local.strong_defects import local_strong
from sdaeverify.probe.local.strong_order import strong_order
from sdaeverify.probe.local.weak_defects import local_weak
from sdaeverify.probe.local.weak_order import weak_order
from sdaeverify_problems.gbm import gbm
from sdaeverify_schemes.euler_maruyama import EulerMaruyama

pytestmark = pytest.mark.benchmark


def probed() -> float:
    """Return the least of both local orders, the reference of the weak one included."""
    scheme, problem = EulerMaruyama(), gbm()
    strong, weak = strong_order(local_strong(scheme, problem)), weak_order(local_weak(scheme, problem))
    return min(strong.order, weak.order)


def test_probing_against_paths(benchmark, report):
    """Both local orders, without sampling error, cost a fraction of the strong order from 8192 paths."""
    pairs = run_pairs(benchmark, probed, lambda: ours(8192), rounds=5)
    report(f"probing {1e3 * min(pairs.ours):.0f} ms, paths / probing", pairs.speed_up, "probing at most 50 ms")
