"""The kit as plain functions: rows that JSON can hold, expected failures, levels, and what a user gets wrong."""

import json
from dataclasses import dataclass
from typing import ClassVar

import pytest

import sdaeverify.testing
from facade import Question, cells_of, load_plugins, newest_LEVEL, ou
from sdaeverify import SDE, Scheme, SchemeError, Step, UsageError
from sdaeverify.numerics import apply
from sdaeverify.testing import Check, check_problem, check_scheme, checks

KEYS = {"subject", "kind", "check", "category", "level", "problem", "status", "reason", "seconds"}
STATUSES = {"passed", "failed", "skipped", "xfailed", "xpassed"}


@dataclass(frozen=True)
class Nameless(Scheme):
    """A scheme without a source."""

    name: ClassVar[str] = "nameless"
    form: ClassVar[type] = SDE

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return Step(state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), noise.dW))


def statuses(rows):
    return {row["check"]: row["status"] for row in rows}


@pytest.fixture(scope="module")
def rows():
    return check_scheme(Nameless(), [ou])


def test_rows_are_data(rows):
    """Each row has the published keys and values, and JSON gives it back."""
    assert json.loads(json.dumps(rows)) == rows
    assert all(row.keys() == KEYS for row in rows)
    assert {row["status"] for row in rows} <= STATUSES
    assert [row["check"] for row in rows] == [check.name for check in checks("scheme")]
    assert {row["problem"] for row in rows} == {"", "ou"}


def test_a_failing_check_raises_nothing(rows):
    """What fails is a row with its reason, what has nothing to ask is skipped."""
    (failed,) = [row for row in rows if row["status"] == "failed"]

    assert failed["check"] == "source"
    assert failed["reason"] == "its class variable source is empty, and it has no claim with a source"
    assert statuses(rows)["claims"] == "skipped"


@pytest.mark.long
def test_a_label_is_as_good_as_the_scheme_or_problem():
    """Registered schemes and problems go by their labels, with parameters."""
    assert check_scheme("stochastic-theta[theta=0.2]", "ou")[0]["subject"] == "stochastic-theta[theta=0.2]"
    assert check_problem("delay-linear[c=0]")[0]["subject"] == "delay-linear[c=0]"


def test_a_scheme_is_put_to_a_few_small_problems_of_its_form():
    """Without problems, the three registered ones of its own form with the smallest states are taken."""
    cells = cells_of(Nameless(), None, load_plugins())

    assert [cell.label for cell in cells] == ["double-well", "forced-ou", "gbm"]
    assert not any(cell.problem.seen_as for cell in cells)


def test_an_expected_failure_is_no_failure():
    """A check that fails as it is expected to is xfailed with both reasons; one that passes is xpassed."""
    talk = {"check": "paths-alone", "problem": "ou", "reason": "neighbours talk"}
    expected = [{"check": "sou*", "reason": "it was a present"}, talk]
    rows = check_scheme(Nameless(), ["ou", "gbm"], expected_failures=expected)
    by_place = {(row["check"], row["problem"]): row for row in rows}

    assert by_place["source", ""]["status"] == "xfailed"
    assert by_place["source", ""]["reason"].startswith("it was a present: its class variable source is empty")
    assert by_place["paths-alone", "ou"]["status"] == "xpassed"
    assert by_place["paths-alone", "gbm"]["status"] == "passed"


@pytest.mark.parametrize(
    ("expected", "text"),
    [
        ({"check": "sauce", "reason": "it was a present"}, "did you mean source"),
        ({"check": "paths-alone", "problem": "gbm", "reason": "another problem"}, "matches no check"),
        ({"check": "source", "reason": " "}, "has no reason"),
        ({"measure": "strong", "reason": "of a claim"}, "unknown field `measure`"),
    ],
)
def test_an_expected_failure_must_name_a_check_and_a_reason(expected, text):
    """A name that matches nothing would hide a failure for ever."""
    with pytest.raises(UsageError, match=text):
        check_scheme(Nameless(), [ou], expected_failures=[expected])


@pytest.mark.parametrize("level", [0, newest_LEVEL + 1, "1"])
def test_a_level_must_be_one_of_the_kit(level):
    """A plugin cannot pin a level that there is not."""
    with pytest.raises(UsageError, match="level must be"):
        check_problem(ou, level=level)


def test_a_check_of_a_later_level_is_skipped(monkeypatch):
    """What came after the level that a plugin pins is skipped with that reason."""
    later = Check("later", "api", 2, lambda subject: "too late")
    monkeypatch.setattr("sdaeverify.testing.questions.checks", lambda kind: (*checks(kind)[:2], later))
    monkeypatch.setattr("sdaeverify.testing.questions.LEVEL", 2)

    assert statuses(check_scheme(Nameless(), [ou]))["later"] == "failed"
    assert statuses(check_scheme(Nameless(), [ou], level=1))["later"] == "skipped"


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: check_scheme(Nameless), r"write Nameless\(\)"),
        (lambda: check_scheme("no-such-scheme"), "unknown scheme"),
        (lambda: check_scheme("*"), "matches"),
        (lambda: check_scheme(Nameless(), ["pendulem"]), "did you mean pendulum"),
        (lambda: check_scheme(Nameless(), []), "problems is empty"),
        (lambda: check_scheme("baoab", ["ou"]), "cannot solve problem 'ou'"),
        (lambda: check_problem(ou()), "uncalled"),
        (lambda: check_problem("no-such-problem"), "unknown problem"),
        (lambda: checks("measure"), "scheme and problem"),
    ],
)
def test_a_wrong_request_is_one_line(call, text):
    """What cannot be asked at all is an error of usage."""
    with pytest.raises(UsageError, match=text) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_whatever_a_check_raises_is_a_failure():
    """A subject that raises fails the check, and only this one."""

    def raising(subject):
        raise SystemExit(3)

    outcome = Question(Check("odd", "api", 1, raising), "x", "scheme", "", None).answer()

    assert outcome["status"] == "failed"
    assert outcome["reason"].startswith("raises SystemExit: 3 (")


def test_what_the_framework_raises_is_a_sentence_already():
    """It says what raises, and so it is told as it is."""

    def raising(subject):
        raise SchemeError("a step of few paths raises IndexError")

    outcome = Question(Check("odd", "api", 1, raising), "x", "scheme", "", None).answer()

    assert (outcome["status"], outcome["reason"]) == ("failed", "a step of few paths raises IndexError")


@pytest.mark.parametrize("kind", ["scheme", "problem"])
def test_the_table_is_in_the_docstring_of_the_package(kind):
    """Each check stands there under its category with what it expects, in the order of the table."""
    text = sdaeverify.testing.__doc__
    lines = [f"{check.name} ({check.category})\n    {check.question}" for check in checks(kind)]

    assert "\n".join(lines) in text
