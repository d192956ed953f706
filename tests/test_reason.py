"""Reasons are values: decisions are taken by their kinds, and their words are made where they are read."""

import pickle

import pytest

from facade import withhold
from sdaeverify import UsageError
from sdaeverify.measuring import Finding, Kind, Opinion, Reason, Verdict

ORDER = Reason("order {order:.2f}", Kind.ORDER, {"order": 0.9})
MORE = Reason("about {paths} paths would decide", Kind.MORE_PATHS, {"paths": 3000})


def test_words_are_made_of_the_parts():
    """Parts are joined as each of them says, and empty ones leave no trace."""
    reason = Reason.of("", ORDER, Reason(), "truncated steps at 1 level").then("no paths to guard it", ", but ")

    assert str(reason) == "order 0.90; truncated steps at 1 level, but no paths to guard it"
    assert f"{Reason()}" == ""
    assert not Reason.of("", Reason())


def test_a_reason_that_is_added_keeps_its_own_joints():
    """Only the first part of what is added is joined anew."""
    assert str(Reason("a").then(Reason("b").then("c", ", but "), ": ")) == "a: b, but c"


def test_braces_of_others_are_no_places_for_numbers():
    """A text without numbers, such as an error message, is shown as it is."""
    assert str(Reason("KeyError: {missing}")) == "KeyError: {missing}"


def test_kinds_are_found_in_all_parts():
    """A kind is there wherever its part stands, whatever the words around it are."""
    reason = Reason.of("paths of another run would decide", ORDER, MORE)

    assert reason.has(Kind.MORE_PATHS)
    assert not Reason("about 3000 paths would decide").has(Kind.MORE_PATHS)
    assert str(reason.before(Kind.MORE_PATHS)) == "paths of another run would decide; order 0.90"
    assert reason.before(Kind.WRONG_LIMIT) == reason
    assert MORE.before(Kind.MORE_PATHS) == Reason()


def test_numbers_of_a_reason_can_be_read():
    """Whoever counts needs no words: the numbers are there, also on the other side of a process."""
    (order, more) = pickle.loads(pickle.dumps(ORDER.then(MORE))).parts

    assert (order.numbers["order"], more.numbers["paths"]) == (0.9, 3000)


def test_remarks_go_behind_and_doubts_before():
    """An opinion gets remarks; a finding that is not verified any more says first why."""
    opinion = Opinion(Verdict.VERIFIED, ORDER, p_verified=1e-9).plus("rounding at 1 level", "")
    withheld = withhold(Finding(quantity="x", **opinion._asdict()), "not confirmed")

    assert str(opinion.reason) == "order 0.90; rounding at 1 level"
    assert (withheld.verdict, withheld.p_verified) == (Verdict.INCONCLUSIVE, 1.0)
    assert str(withheld.reason) == "not confirmed; order 0.90; rounding at 1 level"


def test_a_method_is_no_text():
    """Whoever writes a measure is told what a method is."""
    with pytest.raises(UsageError, match=r"expects a Method, such as .*got 'paths'"):
        Finding(quantity="x", verdict=Verdict.VERIFIED, method="paths")
