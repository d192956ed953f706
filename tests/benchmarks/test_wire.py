"""What a step costs that another program makes: a call, a byte, and a run beside that of the same scheme in NumPy."""

import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from facade import gbm
from sdaeverify import Increment
from sdaeverify_wire.scheme import scheme_of, session_of
from wire import twins
from wire.compiling import built_c

pytestmark = pytest.mark.benchmark

CALLS, MANY = 400, 2**17
# Arrays of a step and its answer: x and dW there, x back, with one number a path each.
BYTES = 3 * 8


def seconds_of_a_step(scheme, paths, calls):
    """Return the shortest time of a step on a number of paths: other work on the machine lengthens it least."""
    problem, x, noise = gbm(), np.ones((1, paths)), Increment(np.zeros((1, paths)), None)
    stepper, found = scheme.prepare(problem, 0.5), []
    for _ in range(calls):
        begun = time.perf_counter()
        stepper(x, 0.0, noise)
        found.append(time.perf_counter() - begun)
    return min(found)


def costs_of_a_call(folder):
    """Return the seconds of a call, and of each byte of its arrays."""
    scheme = scheme_of(built_c(folder, "wired_keep"))
    call = seconds_of_a_step(scheme, 1, CALLS)
    byte = (seconds_of_a_step(scheme, MANY, CALLS // 10) - call) / (BYTES * MANY)
    session_of(scheme.calling).drop()
    return call, byte


def test_call(tmp_path, benchmark, report):
    """A call is one round trip."""
    call, _ = benchmark.pedantic(costs_of_a_call, (tmp_path,), rounds=1)

    report("a step of a program in C, microseconds a call", 1e6 * call, "at most 60")


def test_byte(tmp_path, benchmark, report):
    """The arrays of a call are written, read and copied once each."""
    _, byte = benchmark.pedantic(costs_of_a_call, (tmp_path,), rounds=1)

    report("a step of a program in C, nanoseconds a byte", 1e9 * byte, "at most 2")


def cpu_seconds_of_a_run(folder, plugin):
    """Return the processor time of a default run on gbm, with all processes that it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    given = ["matrix", "--plugin", str(plugin), "-s", "wired-milstein", "-p", "gbm", "--progress", "none"]
    subprocess.run([sys.executable, "-m", "sdaeverify", *given, "--out", plugin.stem], cwd=folder, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def ratio_of_runs(folder):
    """Return the processor time of a run of Milstein's scheme in C over that of the same scheme in NumPy."""
    wired, twin = folder / "wired.py", folder / "twin.py"
    program = built_c(folder, "wired_milstein")
    wired.write_text(f"from sdaeverify_wire import schemes\nsdaeverify_schemes = schemes({program!r})\n")
    source = Path(twins.__file__).read_text().partition("@hookimpl")[0]
    twin.write_text(f"{source}@hookimpl\ndef sdaeverify_schemes():\n    return [Milstein()]\n")
    seconds = [cpu_seconds_of_a_run(folder, plugin) for plugin in (wired, twin)]
    return seconds[0] / seconds[1]


def test_default_run_of_milstein(tmp_path, benchmark, report):
    """A run of Milstein's scheme in C costs little more than one in NumPy: paths come in thousands."""
    ratio = benchmark.pedantic(ratio_of_runs, (tmp_path,), rounds=1)

    report("a default run of Milstein's scheme on gbm, C / NumPy", ratio, "at most 1.5")
