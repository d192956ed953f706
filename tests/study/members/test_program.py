"""The program that puts right schemes to many random members."""

import csv
import subprocess
import sys
from pathlib import Path

import pytest

FORMS = {"HolonomicSDAE", "ConstrainedLangevin", "DelaySDAE", "IndexOneSDAE"}
PROGRAM = Path(__file__).parents[3] / "reports" / "members" / "run.py"


@pytest.mark.slow
def test_no_right_scheme_is_refuted_on_ten_draws(tmp_path):
    """On ten members of each class, no claim of a right scheme is refuted, and most are verified."""
    words = ["--only", "draws", "--draws", "10", "--out", str(tmp_path)]
    subprocess.run([sys.executable, str(PROGRAM), *words], check=True, capture_output=True)
    with (tmp_path / "draws.csv").open(encoding="utf-8") as table:
        rows = [*csv.DictReader(table)]
    counts = {name: sum(int(row[name] or 0) for row in rows) for name in ("verified", "undecided", "refuted")}
    assert counts["refuted"] == 0
    assert counts["verified"] > 9 * counts["undecided"]
    assert {row["class"].split()[0] for row in rows} == FORMS
