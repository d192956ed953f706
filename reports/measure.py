"""Before a release: run the long commands whose results the documentation tells, and keep what they came to.

`python reports/measure.py` runs all of them, `python reports/measure.py gate-ci selftest` those that are named. Each
leaves its command, what it cost and what it counted in `measured.json`, which the site reads; the reference run and
the calibration write their own folders as well.

Seconds differ between machines, and on one machine between days. Each entry has therefore its unit of work as well,
the CPU seconds of 10^8 standard normals, measured in this process before and after the command.
"""

import json
import os
import re
import resource
import shlex
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

import sdaeverify

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "reports" / "measured.json"
# The unit of work: this number of standard normals, drawn in parts that fit the cache of a processor.
NORMALS, PART = 10**8, 10**5


def cost_alone(folder: Path, said: str) -> dict[str, object]:
    """Keep nothing else: the command writes its tables where they are kept."""
    return {}


def gate_counts(folder: Path, said: str) -> dict[str, object]:
    """Keep how many claims came to what."""
    return {"counts": json.loads((folder / "gate.json").read_text())["counts"]}


def sentence(folder: Path, said: str) -> dict[str, object]:
    """Keep the sentence with the counts."""
    return {"said": re.search(r"^.*planted bugs are refuted.*$", said, re.MULTILINE)[0].strip()}


def ratios(folder: Path, said: str) -> dict[str, object]:
    """Keep what is compared, the ratio and the goal of each benchmark."""
    found = json.loads((folder / "benchmarks.json").read_text())["benchmarks"]
    told = [each["extra_info"] for each in found if "ratio" in each["extra_info"]]
    return {"ratios": [{name: each[name] for name in ("what", "ratio", "goal")} for each in told]}


class Run(NamedTuple):
    """A module with its arguments, `{out}` being an empty folder; and what is kept of it."""

    command: str
    keep: Callable[[Path, str], dict[str, object]] = cost_alone


RUNS = {
    "reference": Run("sdaeverify matrix --fresh --out reports/reference --progress none"),
    "gate-smoke": Run("sdaeverify gate --tier smoke --out {out} --progress none", gate_counts),
    "gate-ci": Run("sdaeverify gate --tier ci --out {out} --progress none", gate_counts),
    "selftest": Run("sdaeverify selftest --progress none", sentence),
    "calibration": Run("sdaeverify calibrate --out reports/calibration --progress none"),
    "benchmarks": Run("pytest -q -m benchmark tests/benchmarks --benchmark-json={out}/benchmarks.json", ratios),
}


def measured(run: Run) -> dict[str, object]:
    """Run a command and return what is kept of it; what it prints and its exit code are this program's, too."""
    with TemporaryDirectory() as out:
        words = shlex.split(run.command.replace("{out}", out))
        before, begun, cpu = unit(), time.monotonic(), spent()
        ended = subprocess.run(
            [sys.executable, "-m", *words], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False
        )
        costs = {"cpu_seconds": round(spent() - cpu, 1), "wall_seconds": round(time.monotonic() - begun, 1)}
        print(ended.stdout)
        return {
            "command": f"python -m {run.command.replace(' --progress none', '').replace(' --out {out}', '')}",
            "exit_code": ended.returncode,
            **costs,
            "unit_seconds": round(0.5 * (before + unit()), 2),
            "cores": len(os.sched_getaffinity(0)),
            "date": datetime.now(UTC).date().isoformat(),
            "version": sdaeverify.__version__,
            **run.keep(Path(out), ended.stdout),
        }


def unit() -> float:
    """Return the CPU seconds of the unit of work on one core."""
    rng, normals, begun = np.random.Generator(np.random.Philox(0)), np.empty(PART), time.process_time()
    for _ in range(NORMALS // PART):
        rng.standard_normal(out=normals)
    return time.process_time() - begun


def spent() -> float:
    """Return the seconds of CPU of all processes that this one has started and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main(names: list[str]) -> int:
    """Run what is named, and write what is known after each."""
    if unknown := set(names) - set(RUNS):
        print(f"unknown: {', '.join(sorted(unknown))}; there are {', '.join(RUNS)}", file=sys.stderr)
        return 2
    codes = set()
    for name in names or RUNS:
        known = json.loads(KEPT.read_text()) if KEPT.exists() else {}
        known[name] = measured(RUNS[name])
        codes.add(known[name]["exit_code"])
        KEPT.write_text(json.dumps({name: known[name] for name in RUNS if name in known}, indent=1) + "\n")
    return max(codes)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
