"""Order conditions against their budget: seconds as multiples of it, and memory of the largest class."""

import subprocess
import sys
from time import perf_counter

import pytest

from sdaeverify_orders import orders

pytestmark = pytest.mark.benchmark
SMALL = (("sri1w1", "scalar"), ("sra1", "additive"), ("milstein-areas", "general"))
LARGE = """
import resource, sys
from sdaeverify_orders import orders
orders("platen-weak-2-general", "general", 3)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_three_classes_with_two_motions(benchmark, report, one_core):
    """Scalar, additive and general noise at the claimed orders take 0.3 s together."""

    def ask():
        for scheme, kind in SMALL:
            orders(scheme, kind, 2)

    begun = perf_counter()
    ask()
    report("seconds of three classes, cold", perf_counter() - begun, "0.3")
    benchmark.pedantic(ask, rounds=3)


def test_three_motions_at_weak_order_two(benchmark, report, one_core):
    """2 323 trees and 4 735 forests take 2 s and 300 MB."""
    begun = perf_counter()
    benchmark.pedantic(orders, ("platen-weak-2-general", "general", 3), rounds=1)
    report("seconds of three motions, weak order 2", perf_counter() - begun, "2")
    done = subprocess.run([sys.executable, "-c", LARGE], capture_output=True, text=True, check=True)
    report("megabytes of the same, in a process of its own", int(done.stdout) / 1024, "300")


@pytest.mark.parametrize("scheme", ["platen-weak-2-general", "stochastic-theta"])
def test_all_classes_with_three_motions(scheme, benchmark, report, one_core):
    """Every class that a scheme accepts, with the relations of commuting noise up to weight 5, or Newton's method."""
    begun = perf_counter()
    benchmark.pedantic(orders, (scheme, None, 3), rounds=1)
    report(f"seconds of all classes with three motions, {scheme}", perf_counter() - begun, "3")
