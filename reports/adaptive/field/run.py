"""Judges adaptive solvers of diffrax and torchsde, those that are installed, and writes their table into this folder.

pip install '.[diffrax,torchsde]' && python reports/adaptive/field/run.py [diffrax] [torchsde]
"""

import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pandas as pd

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[2]
PROBLEMS = ("gbm[a=0.1,b=0.8]", "ou", "hyperbolic", "double-well", "shear", "hyperbolic-pair")
# torchsde solves path after path.
PATHS = {"diffrax": "400", "torchsde": "40"}
SIDE_BY_SIDE = 2
ONE_THREAD = {"OMP_NUM_THREADS": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
GIVEN = {**os.environ, **ONE_THREAD, "JAX_PLATFORMS": "cpu"}


def judged(library: str, problem: str) -> tuple[list[dict[str, object]], str]:
    """Return the rows of all solvers of a library on a problem, and what the command said on stderr."""
    plugin = FOLDER / f"{library}_solvers.py"
    command = [sys.executable, "-m", "sdaeverify", "adaptive", "--plugin", str(plugin), f"{library}-*", "-p", problem]
    command += ["--paths", PATHS[library], "--json"]
    # 1 and 3: a claim is refuted, a cell is in error. Both stand in the table.
    done = subprocess.run(command, cwd=ROOT, env=GIVEN, capture_output=True, text=True, check=False)
    return json.loads(done.stdout or "[]"), done.stderr


def save(library: str, rows: list[dict[str, object]]) -> None:
    """Write the table of a library."""
    found = pd.DataFrame(rows)
    work = found.pop("work")
    found["rms"] = [" ".join(f"{each['rms']:.2g}" for each in one) for one in work]
    found["tries"] = [" ".join(f"{each['steps'] + each['rejected']:.0f}" for each in one) for one in work]
    found.to_csv(FOLDER / f"{library}.csv", index=False, float_format="%.4g")


if __name__ == "__main__":
    for library in sys.argv[1:] or PATHS:
        begun, rows = time.monotonic(), list[dict[str, object]]()
        with ThreadPoolExecutor(SIDE_BY_SIDE) as threads:
            for problem, (found, said) in zip(
                PROBLEMS, threads.map(judged, [library] * len(PROBLEMS), PROBLEMS), strict=True
            ):
                print(
                    f"{library} on {problem}: {len(found)} rows, {time.monotonic() - begun:.0f} s {said}", flush=True
                )
                rows += found
                save(library, rows)
