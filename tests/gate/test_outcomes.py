"""From findings to outcomes."""

from dataclasses import replace
from math import inf, nan

import pytest

from facade import ExitCode, FailingClaim, Policy, Status, code_of_gate, idle, outcomes, why_never
from sdaeverify.measuring import Verdict

from .conftest import Fussy, problem, registered, result

ANY = (FailingClaim(reason="known"),)
LAX = (FailingClaim(reason="known", strict=False),)


@pytest.mark.parametrize(
    ("verdict", "plain", "expected"),
    [
        (Verdict.VERIFIED, Status.PASSED, Status.XPASSED),
        (Verdict.REFUTED, Status.FAILED, Status.XFAILED),
        (Verdict.INCONCLUSIVE, Status.UNDECIDED, Status.XFAILED),
        (Verdict.DIVERGED, Status.UNMEASURED, Status.XFAILED),
        (Verdict.ERROR, Status.UNMEASURED, Status.UNMEASURED),
        (Verdict.NOT_RUN, Status.UNMEASURED, Status.UNMEASURED),
    ],
)
def test_status(verdict, plain, expected):
    """Each verdict has a status, and another one where it is expected to fail: nobody expects a crash."""
    (alone,) = outcomes([result(verdict)], Policy())
    (known,) = outcomes([result(verdict)], Policy(expected_failures=ANY))

    assert (alone.status, alone.expected) == (plain, "")
    assert (known.status, known.expected) == (expected, "known")


def test_a_broken_contract_is_no_expected_failure():
    """A cell that is refuted as a whole fails with its reason, whatever is expected of its claims."""
    broken = result(Verdict.REFUTED, quantity="", reason="a step writes into its state", tier=0)
    whole, quantity = outcomes([broken, result(Verdict.REFUTED)], Policy(expected_failures=ANY))

    assert (whole.status, str(whole.finding.reason)) == (Status.FAILED, "a step writes into its state")
    assert code_of_gate([whole, quantity], Policy(expected_failures=ANY), complete=True) is ExitCode.REFUTED
    assert quantity.status is Status.XFAILED


@pytest.mark.parametrize(
    ("traits", "claimed"),
    [((), "order >= 0.5 up"), (("additive-noise",), "order >= 0.5 up to a margin of 0.2 and order >= 1.0 up")],
)
def test_a_broken_contract_is_told_with_the_claims_of_the_problem(traits, claimed):
    """Where a step breaks its contract, the outcome names the claims whose traits the problem has, and no other."""
    found = result(Verdict.REFUTED, scheme=Fussy(), quantity="", reason="a step writes into its state", tier=0)
    cell = replace(found.cell, seen=problem(traits=traits))
    (outcome,) = outcomes([replace(found, cell=cell)], Policy())

    assert outcome.claim == f"{claimed} to a margin of 0.2"


@pytest.mark.parametrize("verdict", [Verdict.OUT_OF_SCOPE, Verdict.NOT_APPLICABLE])
def test_what_is_not_claimed_is_not_gated(verdict):
    """A finding without a claim has no outcome."""
    assert outcomes([result(verdict, claim=None)], Policy()) == []


def test_lax_expectation_may_pass():
    """What is not strictly expected to fail passes where it is verified."""
    (outcome,) = outcomes([result(Verdict.VERIFIED)], Policy(expected_failures=LAX))

    assert outcome.status is Status.PASSED


def test_idle_expectations():
    """An expected failure that no finding matches is told."""
    entries = (FailingClaim(reason="a", quantity="x"), FailingClaim(reason="b", quantity="y"))
    policy = Policy(expected_failures=entries)

    assert idle(outcomes([result(Verdict.REFUTED)], policy), policy) == [entries[1]]


@pytest.mark.parametrize(
    ("pattern", "why"),
    [
        ({}, ""),
        ({"scheme": "plain"}, ""),
        ({"scheme": "plain[kind=other]"}, ""),
        ({"scheme": "pl*[kind=oth?r]"}, ""),
        ({"scheme": "plain[kind=*]"}, ""),
        ({"scheme": "plain[kind=plain]"}, "the label of plain[kind=plain] is written plain"),
        ({"scheme": "plain[size=2]"}, "scheme 'plain' has no parameter 'size'"),
        ({"scheme": "plane"}, "no scheme is named plane; did you mean plain?"),
        ({"problem": "lines"}, "no problem is named lines; did you mean line?"),
        ({"measure": "sharpness"}, "no measure is named sharpness"),
    ],
)
def test_an_expected_failure_that_can_never_match(pattern, why):
    """A label without wildcards is one that its entry makes; one with wildcards needs a name that exists."""
    found = why_never(FailingClaim(reason="known", **pattern), registered(), ())

    assert found.startswith(why)
    assert bool(found) is bool(why)


def test_an_expected_failure_may_name_what_is_planned_alone():
    """The schemes of a plan need not be registered."""
    cell = result(Verdict.REFUTED, scheme=Fussy("own")).cell
    own, other = (FailingClaim(reason="known", scheme=label) for label in ("fussy[kind=own]", "fussy[kind=others]"))
    none = registered(schemes=())

    assert why_never(own, none, [cell]) == ""
    assert why_never(own, none, ()).startswith("no scheme is named fussy")
    assert why_never(other, none, [cell]) == ""


@pytest.mark.parametrize(
    ("verdicts", "options", "locked", "code"),
    [
        ([Verdict.VERIFIED], {}, True, ExitCode.OK),
        ([], {}, True, ExitCode.NOTHING),
        ([Verdict.REFUTED, Verdict.ERROR], {}, False, ExitCode.NOTHING),
        ([Verdict.ERROR, Verdict.REFUTED], {}, True, ExitCode.REFUTED),
        ([Verdict.ERROR, Verdict.INCONCLUSIVE], {"inconclusive": "fail"}, True, ExitCode.NOT_MEASURED),
        ([Verdict.INCONCLUSIVE], {"inconclusive": "fail"}, True, ExitCode.UNDECIDED),
        ([Verdict.INCONCLUSIVE], {}, True, ExitCode.OK),
        ([Verdict.VERIFIED, Verdict.REFUTED], {"expected_failures": ANY}, True, ExitCode.UNEXPECTED),
        ([Verdict.REFUTED, Verdict.ERROR], {"expected_failures": ANY}, True, ExitCode.NOT_MEASURED),
    ],
)
def test_code(verdicts, options, locked, code):
    """The worst outcome gives the code, in the order 5, 1, 3, 7, 4."""
    policy = Policy(**options)

    assert code_of_gate(outcomes(map(result, verdicts), policy), policy, complete=locked) is code


def test_unexpected_before_undecided():
    """An unexpected pass is worse than an undecided claim, and an unmeasured cell is worse than both."""
    policy = Policy(inconclusive="fail", expected_failures=(FailingClaim(reason="known", quantity="y"),))
    results = [result(Verdict.INCONCLUSIVE), result(Verdict.VERIFIED, quantity="y")]

    assert code_of_gate(outcomes(results, policy), policy, complete=True) is ExitCode.UNEXPECTED
    results.append(result(Verdict.ERROR))
    assert code_of_gate(outcomes(results, policy), policy, complete=True) is ExitCode.NOT_MEASURED


@pytest.mark.parametrize(
    ("seen", "asked", "status"),
    [
        (0.3, inf, Status.PASSED),
        (0.3, 0.01, Status.UNDECIDED),
        (0.003, 0.01, Status.PASSED),
        (nan, 0.01, Status.PASSED),
    ],
)
def test_a_policy_asks_for_a_resolution(seen, asked, status):
    """What is verified by evidence that would have shown no smaller error is undecided, with both figures."""
    (outcome,) = outcomes([result(Verdict.VERIFIED, resolution=seen)], Policy(resolution=asked))

    assert outcome.status is status
    assert ("the policy allows 0.01" in str(outcome.finding.reason)) is (status is Status.UNDECIDED)
