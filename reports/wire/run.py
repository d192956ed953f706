"""Measures what programs on the wire cost, and counts the tests of their faults and bits: writes `bounds.csv`.

`python reports/wire/run.py` does both; `python reports/wire/run.py costs` or `tests` one of them. Costs are those of
`tests/benchmarks/test_wire.py`, on this machine; the tests take some ten minutes, and need gcc.
"""

import csv
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

FOLDER = Path(__file__).resolve().parent
TESTS = FOLDER.parents[1] / "tests"
sys.path.insert(0, str(TESTS))

from benchmarks import test_wire  # noqa: E402 - the folder of the tests is no package

FIELDS = ("what", "found", "bound")
# By name: files of tests, a choice among them, and how many there have to be at least.
COUNTED = {
    "faults of programs, each one line and no process left": (["wire/test_faults.py"], "is_one_line", 40),
    "faults of servers on a socket, each one line": (["wire/test_address.py"], "fault_over", 10),
    "runs that are killed and leave no process": (["wire/test_processes.py"], "", 8),
    "comparisons of C with Python to the last bit": (["wire/test_same_bits.py"], "", 16),
}


def costs() -> list[dict[str, object]]:
    """Return what a call, a byte and a run cost."""
    with TemporaryDirectory() as out:
        call, byte = test_wire.costs_of_a_call(Path(out))
        ratio = test_wire.ratio_of_runs(Path(out))
    return [
        {"what": "a step of a program in C, microseconds", "found": f"{1e6 * call:.3g}", "bound": "at most 60"},
        {"what": "each byte of it, nanoseconds", "found": f"{1e9 * byte:.3g}", "bound": "at most 2"},
        {"what": "CPU time of a run of Milstein on gbm, C / NumPy", "found": f"{ratio:.3g}", "bound": "at most 1.5"},
    ]


def tests() -> list[dict[str, object]]:
    """Return how many tests of each kind pass, all of them."""
    found: list[dict[str, object]] = []
    for what, (files, chosen, least) in COUNTED.items():
        command = [sys.executable, "-m", "pytest", "-q", "-m", "", *(str(TESTS / file) for file in files)]
        done = subprocess.run(
            [*command, *(["-k", chosen] if chosen else [])], capture_output=True, text=True, check=False
        )
        print(done.stdout)
        passed = re.search(r"(\d+) passed", done.stdout)
        failed = "" if done.returncode == 0 else ", others fail"
        found.append({"what": what, "found": f"{passed[1] if passed else 0}{failed}", "bound": f"at least {least}"})
    return found


def main(names: list[str]) -> None:
    """Measure what is named, keep the other rows of the file, and write it."""
    parts, file = {"costs": costs, "tests": tests}, FOLDER / "bounds.csv"
    known = list(csv.DictReader(file.open())) if file.exists() else []
    rows = {row["what"]: row for row in known}
    for name in names or parts:
        rows |= {str(row["what"]): row for row in parts[name]()}
    with file.open("w", newline="") as opened:
        writer = csv.DictWriter(opened, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows.values())


if __name__ == "__main__":
    main(sys.argv[1:])
