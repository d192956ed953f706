"""What a finding is told as: one meaning a column, and no order without information."""

from math import inf, isnan, nan
from types import SimpleNamespace

import pytest

from facade import CHANGES_SIGN, Cell, CellResult, EulerMaruyama, Interval, VerdictRow, gbm, problem_spec
from sdaeverify import Claim
from sdaeverify.measuring import Finding, Kind, Method, Reason, Verdict

CLAIM = Claim(measure="strong", value=0.5, source="a book")
WEAK = {"slope": -14.05, "slope_low": -22.17, "slope_high": -5.93, "local_order": 0.9988}


def finding(verdict=Verdict.VERIFIED, **changed):
    """Return a finding on a strong order that one step decides and paths guard, with some fields changed."""
    told = {
        "quantity": "x",
        "claim": CLAIM,
        "reason": Reason("local order 0.480"),
        "tier": 1,
        "estimate": 0.392,
        "low": 0.357,
        "high": 0.428,
        "details": {"local_order": 0.48},
        "method": Method("local order", 1, "paths", "exact solution"),
    }
    return Finding(verdict=verdict, **{**told, **changed})


def read_finding(found, value_of=""):
    """Return the row of a finding of a measure that estimates an order, or something else."""
    measure = SimpleNamespace(name="strong", value_of=value_of)
    return VerdictRow.from_finding(found, CellResult(Cell(EulerMaruyama(), problem_spec(gbm), measure), (found,)))


def weak(*, resolved=0.2, informative=False, **changed):
    """Return a finding on an observable by differences of means."""
    told = {
        "claim": None,
        "estimate": -14.05,
        "low": -22.17,
        "high": -5.93,
        "tier": 3,
        "method": Method("successive differences along paths", 3),
        "details": {**WEAK, "resolved": resolved, "informative": informative},
    }
    return finding(Verdict.OUT_OF_SCOPE, **{**told, **changed})


def test_noise_is_no_order_and_the_local_order_stays():
    """Where mean differences are below their standard errors the paths tell no order, and the reason says why."""
    reading = read_finding(weak())
    assert not reading.path.known
    assert reading.local_order == 0.9988
    assert reading.reason == "Local order 0.480; bias below sampling noise (0.2 standard errors; 3 needed)."


def test_errors_that_change_sign_tell_no_order():
    """Resolved differences of both signs are no noise, and tell no order either: the measure's remark says so."""
    reading = read_finding(weak(resolved=7.0, reason=CHANGES_SIGN))
    assert not reading.path.known
    assert reading.reason == "The error changes sign between step sizes, hence no slope."


def test_an_interval_without_end_is_no_order():
    """An estimate whose interval is not finite says nothing."""
    found = finding(method=Method("paired replicated chains", 3), tier=3, low=-inf, high=inf, details={})
    reading = read_finding(found)
    assert not reading.path.known
    assert not reading.estimate.known
    assert reading.reason.endswith("; no finite interval along paths.")


def test_a_claim_decided_by_one_step_keeps_both_orders_apart():
    """The estimate of a weak finding with a claim is its local order; the order along paths is another column."""
    orders = {"slope": 1.1, "slope_low": 0.9, "slope_high": 1.3, "local_order": 0.99}
    found = finding(
        method=Method("local weak order", 1, "successive differences"),
        estimate=0.99,
        low=nan,
        high=nan,
        details={**orders, "resolved": 9.0, "informative": True},
    )
    reading = read_finding(found)
    assert (reading.local_order, reading.path) == (0.99, (1.1, 0.9, 1.3))
    assert (reading.decided_by, reading.guarded_by) == ("T1", "successive differences")


def test_an_estimate_along_paths_is_no_local_order():
    """Where one step decides and its order is not told, the order along paths does not stand in for it."""
    reading = read_finding(finding(details={}))
    assert reading.path == (0.392, 0.357, 0.428)
    assert isnan(reading.local_order)


def test_a_tick_comes_with_claim_margin_and_tier():
    """What is verified says by which tier, up to which margin, and what guards it."""
    reading = read_finding(finding())
    assert (reading.claim, reading.margin, reading.decided_by) == ("order >= 0.5", 0.2, "T1")
    assert reading.guarded_by == "paths, exact solution"
    assert reading.path == (0.392, 0.357, 0.428)


def test_what_nothing_decides_names_no_tier():
    """A finding without a verdict on a claim is decided by nothing."""
    assert read_finding(finding(Verdict.INCONCLUSIVE)).decided_by == ""


def test_the_kinds_of_a_reason_stand_beside_it():
    """Those of its parts that have one, each once, whatever their numbers are."""
    parts = (Reason("order {p:.1f}", Kind.ORDER, {"p": p}) for p in (1.0, 2.0))
    reason = Reason.of(*parts, "and more", Reason("about {n} paths", Kind.MORE_PATHS, {"n": 9}))
    assert read_finding(finding(reason=reason)).reason_kind == "order, paths that would decide"


@pytest.mark.parametrize(
    ("changed", "value_of", "told"),
    [
        ({"method": Method("spectral radius", 2), "tier": 2}, "largest stable h", "largest stable h"),
        (
            {"method": Method("largest residual along paths", 3), "tier": 3, "value_of": "largest residual"},
            "",
            "largest residual",
        ),
        ({"method": Method("paired replicated chains", 3), "tier": 3, "value_of": "bias"}, "", "bias"),
        ({"method": Method("stationary law of the transition operator", 2), "tier": 2, "details": {}}, "", "order"),
    ],
)
def test_what_is_no_order_along_paths_says_what_it_is(changed, value_of, told):
    """The value of a finding is never taken for an order along paths."""
    reading = read_finding(finding(**changed), value_of)
    assert reading.value_of == told
    assert reading.estimate == Interval(0.392, 0.357, 0.428)
    assert not reading.path.known
    assert isnan(reading.local_order) or told == "order" or changed.get("details") is None
