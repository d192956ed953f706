"""What a row of the verdicts is read as: one meaning a field, and no order without information."""

import csv
from math import isfinite, isnan
from pathlib import Path

import pytest

from report.rows import verdict, weak
from sdaeverify.report.reading import claimed_order, read_row

REFERENCE = Path(__file__).resolve().parents[2] / "reports" / "reference" / "verdicts.csv"


def test_noise_is_no_order_and_the_local_order_stays():
    """Where mean differences are below their standard errors the paths tell no order, and it is said why."""
    reading = read_row(weak())
    assert not reading.path.known
    assert reading.local_order == pytest.approx(0.9988)
    assert reading.no_order == "a mean difference is 0.2 standard errors"


def test_errors_that_change_sign_tell_no_order():
    """Resolved differences of both signs are no noise, and tell no order either."""
    assert read_row(weak(resolved="7.0")).no_order == "its errors change sign between levels"


def test_an_interval_without_end_is_no_order():
    """An estimate whose interval is not finite says nothing."""
    row = verdict(
        measure="invariant",
        method="paired replicated chains (T3)",
        tier="T3",
        ci_low="-inf",
        ci_high="inf",
        local_order="",
    )
    reading = read_row(row)
    assert not reading.path.known
    assert not reading.value.known
    assert reading.no_order


def test_a_claim_decided_by_one_step_keeps_both_orders_apart():
    """The estimate of a weak row with a claim is its local order; the order along paths has columns of its own."""
    row = weak(
        claim="order >= 1.0",
        margin="0.2",
        verdict="verified",
        estimate="0.99",
        ci_low="",
        ci_high="",
        tier="T1",
        method="local weak order (T1), guarded by successive differences",
        informative="True",
        resolved="9.0",
        path_order="1.1",
        path_low="0.9",
        path_high="1.3",
        local_weak_order="0.99",
    )
    reading = read_row(row)
    assert (reading.local_order, reading.path) == (0.99, (1.1, 0.9, 1.3))
    assert (reading.decided_by, reading.guarded_by) == ("T1", "successive differences")


def test_a_tick_comes_with_claim_margin_and_tier():
    """What is verified says by which tier, up to which margin, and what guards it."""
    reading = read_row(verdict())
    assert (reading.claim, reading.margin, reading.decided_by) == ("order >= 0.5", 0.2, "T1")
    assert reading.guarded_by == "paths, exact solution"
    assert reading.path == (0.392, 0.357, 0.428)


def test_what_nothing_decides_names_no_tier():
    """A row without a verdict on a claim is decided by nothing."""
    assert read_row(verdict(verdict="inconclusive")).decided_by == ""


@pytest.mark.parametrize(
    ("changed", "value_of"),
    [
        (
            {"measure": "stability", "claim": "A-stable", "method": "spectral radius (T2)", "tier": "T2"},
            "largest stable h",
        ),
        (
            {"measure": "drift", "claim": "round-off", "method": "largest residual along paths (T3)", "tier": "T3"},
            "largest residual",
        ),
        (
            {
                "measure": "invariant",
                "claim": "unbiased within 0.1",
                "method": "paired replicated chains (T3)",
                "tier": "T3",
            },
            "bias",
        ),
        (
            {
                "measure": "invariant",
                "method": "stationary law of the transition operator (T2)",
                "tier": "T2",
                "local_order": "",
            },
            "order",
        ),
    ],
)
def test_what_is_no_order_along_paths_says_what_it_is(changed, value_of):
    """The value of a row is never taken for an order along paths."""
    reading = read_row(verdict(**changed))
    assert reading.value_of == value_of
    assert reading.value.value == pytest.approx(0.392)
    assert not reading.path.known


def test_the_order_of_a_claim_is_read_from_its_text():
    """Only a claim of an order names one."""
    assert claimed_order("order >= 1.5") == 1.5
    assert isnan(claimed_order("round-off"))


def test_no_row_of_the_reference_report_tells_noise():
    """Every order along paths there has a finite interval and comes from differences that paths resolve."""
    with REFERENCE.open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["verdict"] != "not_applicable"]
    noise = [row for row in rows if row["informative"] == "False"]
    readings = [(row, read_row(row)) for row in rows]
    assert len(noise) > 600
    assert not any(read_row(row).path.known for row in noise)
    assert all(isfinite(r.path.low) and isfinite(r.path.high) for _, r in readings if r.path.known)
    ticks = [r for _, r in readings if r.verdict == "verified"]
    assert all(r.claim and r.decided_by for r in ticks)
    assert all(r.margin > 0 for r in ticks if r.claim.startswith("order"))
    # A claim that is decided has an order with its interval, one without sampling error, or another value.
    assert all(
        r.path.known or not isnan(r.local_order) or r.value.known or not r.claim.startswith("order") for r in ticks
    )
