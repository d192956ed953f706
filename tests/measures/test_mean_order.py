"""The order of weak errors from paths whose law is known, without any simulation."""

from dataclasses import replace

import numpy as np
import pytest

from cells import claimant
from facade import ROUNDING, TOO_FEW, MeanObserver, Weak, gbm, mean_order, means_of
from sdaeverify import Claim, Moment, Settings
from sdaeverify.measuring import Evidence, Snapshot, Tally, Verdict, decide

SETTINGS = Settings(paths=4000)
H = np.array([1.0 / n for n in SETTINGS.steps])
CLAIM = Claim(measure="weak", value=1.0, source="test")
LIMIT = 2.0


def problem(*, truth=True, value=LIMIT):
    """Return a problem whose only observable is x, with its expectation or without any truth."""
    known = (Moment(observable="x", value=lambda t: value, source="test"),) if truth else ()
    return replace(gbm(), observables={"x": lambda t, parts: parts["x"][0]}, truths=known)


def evidence(errors, *, spread=0.01, jitter=0.0, seen=None, failed=(0,) * 6, off=0.0):
    """Return the evidence on x_l = LIMIT + z + error_l (1 + y), z and y of each path being the same at all levels."""
    rng, paths = np.random.default_rng(3), 4000
    z, y = spread * rng.standard_normal(paths), 0.1 * rng.standard_normal(paths)
    own = jitter * rng.standard_normal((len(H), paths))
    levels = [{"x": (LIMIT + z + error * (1.0 + y) + noise)[None]} for error, noise in zip(errors, own, strict=True)]
    seen = problem() if seen is None else seen
    observer = MeanObserver(seen, levels[0], SETTINGS)
    truths = {"x": (LIMIT + z)[None]}, {"x": (LIMIT + z + off)[None]}
    observer.after_coarsest_step(Snapshot(levels, *truths))
    zeros = np.zeros(len(H))
    health = {"failed": np.array(failed, dtype=float), "lost": zeros, "truncated": zeros, "steps": zeros + 1e6}
    return Evidence(claimant(CLAIM), seen, seen, SETTINGS, observer.tally(), Tally(sums=health))


def found(errors, **options):
    """Return the order of the means of `evidence`."""
    known = evidence(errors, **options)
    with np.errstate(all="ignore"):
        return mean_order(known, means_of(known)["x"], CLAIM)


def test_successive_differences_show_the_order():
    """Errors c h have mean differences of order 1, resolved although each mean is not."""
    order = found(0.1 * H)

    assert order.slope.value == pytest.approx(1.0, abs=4.0 * order.slope.se + 1e-9)
    assert order.tests.verified < 1e-9
    assert order.tests.refuted > 0.01


def test_lower_order_is_refuted():
    """Errors of order 1/2 refute a claim of 1."""
    assert found(0.1 * H**0.5).tests.refuted < 1e-9


@pytest.mark.parametrize("errors", [0.1 * H**0.5, 0.1 * H + 0.05], ids=["order", "limit"])
def test_steps_that_do_not_resolve_the_fastest_time_refute_nothing(errors):
    """A low order and a wrong limit on steps above 1/64 of the fastest time, of pairs, stay suspicions."""
    coarse, fine = (
        found(errors, seen=replace(problem(), fastest_time=times * H[-1])).tests for times in (127.0, 128.0)
    )
    assert coarse.refuted == 1.0
    assert coarse.suspected <= fine.refuted < 1e-9
    assert coarse.growth == np.inf
    assert "does not resolve the fastest time" in str(coarse.reason)
    assert "does not resolve" not in str(fine.reason)


def test_an_order_that_comes_late_is_not_refuted():
    """Errors h/(1 + 12 h) have slopes below 1 on coarse steps, which the fit with a correction takes back."""
    late = found(0.1 * H / (1.0 + 12.0 * H))

    assert late.slope.value < 0.8
    assert late.tests.refuted > 0.01


def test_a_wrong_limit_is_refuted():
    """Successive differences do not see a wrong limit; the known expectation does."""
    order = found(0.1 * H, seen=problem(value=LIMIT + 0.01))

    assert order.slope.value == pytest.approx(1.0, abs=0.1)
    assert order.tests.refuted < 1e-6
    assert "wrong limit" in str(order.tests.reason)


def test_without_a_truth_nothing_is_verified():
    """Differences that fall may fall towards anything."""
    order = found(0.1 * H, seen=problem(truth=False))

    assert order.tests.verified == 1.0
    assert "the exact mean is not known" in str(order.tests.reason)


@pytest.mark.parametrize("jitter", [0.0, 0.004, 0.05], ids=["surely above the bound", "about it", "unresolved"])
def test_without_a_truth_no_number_of_paths_is_asked_for(jitter):
    """The number would move with each run, as no number of paths verifies; a truth is asked for instead."""
    seen = problem(truth=False)
    order = found(0.1 * H, seen=seen, jitter=jitter)
    reason = str(decide(order.tests, evidence(0.1 * H, seen=seen)).reason)

    assert "unless a Moment of x or a Pathwise truth is attached to the problem" in reason
    assert "would decide" not in reason


def test_without_a_truth_a_low_order_is_still_refuted_or_more_paths_are_asked_for():
    """More paths tell an order below the bound from it: the wrong twin of an order that only lacks a truth."""
    seen = problem(truth=False)
    surely, nearly = (
        found(0.1 * H**power, seen=seen, jitter=jitter) for power, jitter in ((0.5, 0.0), (0.78, 0.004))
    )

    assert decide(surely.tests, evidence(0.1 * H, seen=seen)).verdict is Verdict.REFUTED
    assert nearly.slope.value < 0.8
    assert "paths would decide (--paths)" in str(decide(nearly.tests, evidence(0.1 * H, seen=seen)).reason)


def test_a_wrong_limit_is_seen_from_a_reference():
    """A truth with an error of its own confirms a limit to within that error."""
    truth = replace(gbm().pathwise, order=1.5)
    seen = replace(problem(truth=False), truths=(truth,))

    right, wrong = found(0.1 * H, seen=seen, off=1e-6), found(0.1 * H + 0.01, seen=seen, off=1e-6)
    blind = found(0.1 * H + 0.01, seen=seen, off=0.05)

    assert right.tests.verified < 1e-9
    assert right.tests.refuted > 0.01
    assert wrong.tests.refuted < 1e-6
    assert blind.tests.refuted > 0.01


def test_of_expectation_and_reference_the_sharper_one_judges_the_limit():
    """An error that drowns in the spread of the expectation shows against a reference on the same paths."""
    truth = Moment(observable="x", value=lambda t: LIMIT, source="test")
    seen = replace(problem(truth=False), truths=(replace(gbm().pathwise, order=1.5), truth))

    both = found(0.1 * H + 0.01, seen=seen, spread=1.0, off=1e-6)
    alone = found(0.1 * H + 0.01, seen=problem(), spread=1.0)
    blurred = found(0.1 * H + 0.5, seen=seen, off=1.0)

    assert both.tests.refuted < 1e-6
    assert both.tests.blind <= 1.0
    assert alone.tests.refuted > 0.01
    # The expectation is the sharper one where the reference is known badly.
    assert blurred.tests.refuted < 1e-6


def test_differences_lost_in_noise_decide_nothing():
    """A mean difference below three standard errors is unresolved, and the tests say what would resolve it."""
    order = found(1e-4 * H, jitter=0.01)

    assert order.resolved < 3.0
    assert order.tests.verified == 1.0
    assert "below sampling noise" in str(order.tests.reason)
    assert order.tests.growth > 1.0


def test_a_functional_that_changes_sign_is_not_used():
    """An accidental zero of the error between two levels makes an observable uninformative."""
    order = found(H * (H - 4.0 * H[-2]))

    assert "changes sign" in str(order.remark)
    assert order.tests.verified == 1.0
    assert order.tests.refuted > 0.01


def test_levels_with_failures_are_not_fitted():
    """With fewer than three sound levels there is no order."""
    assert found(0.1 * H, failed=(1, 1, 1, 1, 1, 0)).remark.text == TOO_FEW


def test_exact_means_have_no_order():
    """A scheme without weak error is not judged by the order of its rounding."""
    assert found(0.0 * H, spread=0.0).remark.text == ROUNDING


def test_what_paths_and_their_order_say_alike_is_said_once():
    """The reason of a finding without weak error does not repeat itself."""
    (finding,) = Weak().judge(evidence(0.0 * H, spread=0.0)).findings
    assert str(finding.reason).count("no error beyond round-off") == 1


def test_differences_that_do_not_fall_yet_leave_the_limit_open():
    """Who comes up by more with each halving may still come to the limit; it stays suspicious."""
    growing, falling = found([3.0, 2.7, 2.35, 1.95, 1.5, 1.0]), found([1.3, 1.18, 1.1, 1.05, 1.03, 1.02])

    assert growing.tests.limit == 1.0
    assert growing.tests.suspected < 1e-9
    assert "do not fall yet" in str(growing.tests.reason)
    assert falling.tests.limit < 1e-9
