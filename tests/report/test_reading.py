"""What a row of the verdicts is read as, and that the committed report tells no order of noise."""

import json
import re
from math import inf, isfinite, isnan
from pathlib import Path

import pytest

from facade import Interval, VerdictRow, read_tables
from report.rows import verdict, weak
from sdaeverify import UsageError

read_row = VerdictRow.from_row
REFERENCE = Path(__file__).resolve().parents[2] / "reports" / "reference"


def test_a_row_is_read_as_it_was_written():
    """Its columns, numbers as numbers, are those of the reading."""
    reading = read_row(verdict())
    assert (reading.claim, reading.margin, reading.path) == ("order >= 0.5", 0.2, Interval(0.392, 0.357, 0.428))
    assert read_row(reading.cells) == reading
    assert not read_row(weak()).path.known


def test_a_record_for_programs_has_no_number_that_json_lacks():
    """Nothing is null, infinity is a text, whole numbers are numbers."""
    told = read_row(verdict(local_order=str(inf), margin="")).record
    assert (told["local_order"], told["margin"], told["paths"], told["view"]) == ("inf", None, 256.0, None)


def test_the_order_of_a_claim_is_a_number_of_its_own():
    """Nobody reads it from the words of the claim."""
    assert read_row(verdict(claim="in other words", claimed_order="1.5")).claimed_order == 1.5
    assert isnan(read_row(verdict(claim="order >= 1.5", claimed_order="")).claimed_order)


@pytest.mark.parametrize(("found", "told"), [(1, "in format 1"), (None, "in no known format"), (99, "in format 99")])
def test_a_run_in_another_format_is_told_in_one_line(tmp_path, found, told):
    """Its columns would mean something else; what to do is said."""
    (tmp_path / "verdicts.csv").write_text("scheme,problem,measure,quantity\na,b,c,d\n")
    (tmp_path / "run.json").write_text(json.dumps({"schema_version": found}))
    with pytest.raises(UsageError, match=f"is {told}, this version of sdaeverify reads format 3: run it again"):
        read_tables(tmp_path)


@pytest.fixture(scope="module")
def reference():
    """Return the tables of the committed report."""
    return read_tables(REFERENCE)


def test_no_row_of_the_reference_report_tells_noise(reference):
    """Every order along paths there has a finite interval and comes from differences that paths resolve."""
    readings = [read_row(row) for row in reference.verdicts]
    keys = ("scheme", "problem", "quantity")
    sampled = [row for row in reference.details if row.get("informative") == "False" and row["slope"]]
    noise = {tuple(row[k] for k in keys) for row in sampled}
    assert len(noise) > 600
    weakly = [row for row in reference.verdicts if row["measure"] == "weak"]
    assert not any(row["path_order"] for row in weakly if tuple(row[k] for k in keys) in noise)
    words = "below sampling noise|paths show no order|changes sign between|cannot exclude a violation|no slope"
    said = re.compile(words, re.IGNORECASE)
    assert all(said.search(row["reason"]) for row in weakly if tuple(row[k] for k in keys) in noise)
    assert all(isfinite(r.path.low) and isfinite(r.path.high) for r in readings if r.path.known)


def test_each_tick_of_the_reference_report_has_claim_margin_tier_and_estimate(reference):
    """A claim that is decided has an order with its interval, one without sampling error, or another value."""
    ticks = [r for r in map(read_row, reference.verdicts) if r.verdict == "verified"]
    assert all(r.claim and r.decided_by for r in ticks)
    assert all(r.margin > 0 for r in ticks if r.claim.startswith("order"))
    orders = [r for r in ticks if r.claim.startswith("order")]
    assert all(r.path.known or not isnan(r.local_order) or r.estimate.known for r in orders)
