"""Judges adaptive solvers of diffrax and torchsde, those that are installed, and writes their tables beside itself.

pip install '.[diffrax,torchsde]' && python reports/adaptive/field/run.py [diffrax] [torchsde]
"""

import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[2]
LIBRARIES = ("diffrax", "torchsde")
PROBLEMS = ("gbm[a=0.1,b=0.8]", "ou", "hyperbolic", "double-well", "shear")
ONE_THREAD = {"OMP_NUM_THREADS": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
GIVEN = {**os.environ, **ONE_THREAD, "JAX_PLATFORMS": "cpu"}


def judged(library: str) -> list[dict[str, object]]:
    """Return the rows of all solvers of a library."""
    plugin = FOLDER / f"{library}_solvers.py"
    command = [sys.executable, "-m", "sdaeverify", "adaptive", "--plugin", str(plugin), f"{library}-*", "--json"]
    command += [word for problem in PROBLEMS for word in ("-p", problem)]
    # 1 and 3: a claim is refuted, a cell is in error. Both stand in the table.
    done = subprocess.run([*command, "-j", "2"], cwd=ROOT, env=GIVEN, stdout=subprocess.PIPE, text=True, check=False)
    return list(json.loads(done.stdout or "[]"))


def save(library: str, rows: list[dict[str, object]]) -> None:
    """Write the table of a library."""
    found = pd.DataFrame(rows)
    work = found.pop("work")
    found["rms"] = [" ".join(f"{each['rms']:.2g}" for each in one) for one in work]
    found["tries"] = [" ".join(f"{each['steps'] + each['rejected']:.0f}" for each in one) for one in work]
    found.to_csv(FOLDER / f"{library}.csv", index=False, float_format="%.4g")


def processor_seconds() -> float:
    """Return the seconds of processor time that processes which have ended have taken."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    for library in sys.argv[1:] or LIBRARIES:
        begun, before = time.monotonic(), processor_seconds()
        rows = judged(library)
        save(library, rows)
        took = f"{time.monotonic() - begun:.0f} s, {processor_seconds() - before:.0f} s of processor time"
        solvers = len({row["solver"] for row in rows})
        print(f"{library}: {solvers} configurations, {len(rows)} rows, {took}", flush=True)
