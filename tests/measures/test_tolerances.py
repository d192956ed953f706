"""How far orders of one step fall short of their claims in the reference run, beside the accepted amounts."""

import csv
from pathlib import Path

import numpy as np
import pytest

from sdaeverify.measures import invariant
from sdaeverify.measures.strong import findings as strong

VERDICTS = Path(__file__).parents[2] / "reports" / "reference" / "verdicts.csv"
# Of the column `decided_by`.
ONE_STEP, OPERATOR = "T1", "T2"
# Orders are multiples of 1/2: what falls short by more is of the next lower one.
NEXT = 0.4


def shortfalls(measure, tier, column):
    """Return the claimed orders minus the computed ones, of all findings of a measure that a tier decides."""
    with VERDICTS.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["measure"] == measure and row["decided_by"] == tier]
    found = np.array([float(row["claimed_order"]) - float(row[column]) for row in rows if row["claimed_order"]])
    return found[np.isfinite(found)]


@pytest.mark.parametrize(
    ("measure", "tier", "column", "tolerance", "largest"),
    [
        ("strong", ONE_STEP, "local_order", strong.TOLERANCE, 0.05),
        ("invariant", OPERATOR, "value_low", invariant.TOLERANCE, 0.05),
    ],
)
def test_orders_are_right_or_off_by_a_half(measure, tier, column, tolerance, largest):
    """Right schemes need some of the tolerance, and no order lies between the tolerance and the next lower order."""
    found = shortfalls(measure, tier, column)

    assert len(found) > 100
    assert largest < found[found < NEXT].max() <= tolerance
