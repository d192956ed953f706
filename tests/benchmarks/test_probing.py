"""Local orders by probing against the order of the same scheme along paths."""

import pytest

from benchmarks.pairs import run_pairs
from benchmarks.study import ours
from facade import EulerMaruyama, gbm, local_strong, local_weak, strong_orders, weak_order

pytestmark = pytest.mark.benchmark


def probed() -> float:
    """Return the least of both local orders, the reference of the weak one included."""
    scheme, problem = EulerMaruyama(), gbm()
    strong, weak = strong_orders(local_strong(scheme, problem))[-1], weak_order(local_weak(scheme, problem))
    return min(strong.order, weak.order)


def test_probing_against_paths(benchmark, report):
    """Both local orders, without sampling error, cost a fraction of the strong order from 8192 paths."""
    pairs = run_pairs(benchmark, probed, lambda: ours(8192), rounds=5)
    report(f"probing {1e3 * min(pairs.ours):.0f} ms, paths / probing", pairs.speed_up, "probing at most 50 ms")
