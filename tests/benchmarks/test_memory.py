"""Peak memory of a study, in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.benchmark

STATUS = Path("/proc/self/status")
# The kernel's own high-water mark: getrusage would report that of the process which started this one.
PROGRAM = f"""
import sdaeverify
sdaeverify.verify({{arguments}})
print(next(line.split()[1] for line in open("{STATUS}") if line.startswith("VmHWM")))
"""
MANY_PATHS = {
    "gbm, 10^6 paths": "'euler-maruyama', 'gbm', 'strong', paths=10**6, max_looks=1",
    "pendulum, 10^5 paths": "'half-explicit-euler[truncation=none]', 'pendulum', 'strong', paths=10**5, max_looks=1",
}
STUDY = "'euler-maruyama', 'gbm', 'strong', paths=8192, coarsest=8, max_looks=1"
LIMIT = 500.0


@pytest.mark.parametrize("study", MANY_PATHS)
def test_memory_of_many_paths(study, benchmark, report):
    """A study of many paths stays below 500 MB."""
    peak = benchmark.pedantic(peak_megabytes, args=(MANY_PATHS[study],), rounds=1)
    report(f"{study}, peak in MB", peak, "below 500")
    assert peak < LIMIT


def test_memory_of_many_steps(benchmark, report):
    """Eight times as many steps at the finest level hardly need more memory."""
    few = peak_megabytes(f"{STUDY}, levels=6")
    many = benchmark.pedantic(peak_megabytes, args=(f"{STUDY}, levels=9",), rounds=1)
    report(f"levels 8..2048 / 8..256, {many:.0f} MB / {few:.0f} MB", many / few, "at most 1.1")
    assert many < LIMIT


def peak_megabytes(arguments: str) -> float:
    """Run `sdaeverify.verify` in a fresh process and return its peak memory, 10^6 bytes."""
    if not STATUS.exists():
        pytest.skip("this platform does not report the peak memory of a process")
    program = PROGRAM.format(arguments=arguments)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment)
    return 1024 * float(run.stdout) / 1e6
