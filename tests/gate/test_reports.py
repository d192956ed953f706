"""Reports: JSON, a summary and words."""

import json

from hypothesis import given
from hypothesis import strategies as st

from facade import FailingClaim, Policy, markdown_report
from sdaeverify.gate.words import json_report, text_report
from sdaeverify.measuring import Method, Verdict

from .conftest import NASTY, Plain, gated, result

ODD = st.text(st.sampled_from("a~\n\r`<&![](\x00\x1b:"), max_size=12)


def test_json_is_strict(everything):
    """The report is JSON without NaN and infinities, and has a row for each outcome."""
    report = json_report(gated(*everything, result(Verdict.VERIFIED, estimate=float("inf")), code=1, words="red"))
    again = json.loads(json.dumps(report, allow_nan=False))

    assert again == report
    assert len(again["outcomes"]) == 7
    assert again["counts"] == {"failed": 1, "passed": 2, "undecided": 1, "unmeasured": 3}
    assert "\x1b" not in str(report)


def test_row_of_the_json():
    """A row has the claim, the interval and the command."""
    found = result(Verdict.REFUTED, estimate=0.5, low=0.4, high=0.6, method=Method("paths"), tier=3)
    (row,) = json_report(gated(found))["outcomes"]

    assert (row["scheme"], row["problem"], row["measure"], row["quantity"]) == ("plain", "line", "sharp", "x")
    assert (row["path_order"], row["path_low"], row["path_high"], row["red"]) == (0.5, 0.4, 0.6, True)
    assert (row["claim"], row["margin"]) == ("order >= 1.0", 0.2)
    assert row["reproduce"].startswith("python -m sdaeverify matrix -s plain -p line -m sharp")


def test_no_command_without_a_name():
    """What is not registered has no command."""
    (row,) = json_report(gated(result(Verdict.REFUTED), unnamed=frozenset({"plain"})))["outcomes"]

    assert row["reproduce"] == ""


@given(reason=ODD, kind=ODD, line=ODD)
def test_summary_stays_in_its_block(reason, kind, line):
    """No text ends the block that the summary stands in, or begins a line of it."""
    found = result(Verdict.REFUTED, scheme=Plain(kind), reason=reason)
    _, _, first, *lines, last = markdown_report(gated(found, violations=(line,))).splitlines()

    assert first == last == "~~~~"
    assert not any(text.startswith("~") for text in lines)
    assert all(text.isprintable() for text in lines)


def test_summary_of_many():
    """A long list is cut, and says so; a scheme has a row of counts."""
    lines = markdown_report(gated(*(result(Verdict.REFUTED, quantity=f"x{n}") for n in range(202)))).splitlines()

    assert "and 2 more that fail, see gate.json" in lines
    assert lines[-2].split() == ["scheme", "plain", "202"]


def test_words():
    """What fails is told with claim, interval, reason and command, the rest in a line each, then the counts."""
    found = result(Verdict.REFUTED, estimate=0.5, low=0.4, high=0.6, reason="too low", method=Method("paths"))
    lines = list(text_report(gated(result(Verdict.VERIFIED), result(Verdict.INCONCLUSIVE), found)))

    assert lines[:6] == [
        "refuted: plain on line, sharp x: claimed order >= 1.0 up to a margin of 0.2",
        "  source: made up",
        "  estimate: 0.5, between 0.4 and 0.6 (99 % interval)",
        "  reason: too low",
        "  method: paths",
        lines[5],
    ]
    assert lines[5].startswith("  reproduce: python -m sdaeverify matrix -s plain")
    assert lines[7] == "undecided: plain on line, sharp x: claimed order >= 1.0 up to a margin of 0.2: because"
    assert lines[-1] == "3 claimed quantities: 1 verified, 1 refuted, 1 undecided"


def test_words_of_what_does_not_fail():
    """What is undecided says why, what fails as expected why that is expected; a long reason is cut."""
    policy = Policy(expected_failures=(FailingClaim(reason="issue 12", quantity="y"),))
    found = (
        result(Verdict.INCONCLUSIVE, reason="too few paths"),
        result(Verdict.INCONCLUSIVE, quantity="z", reason="long " * 200),
        result(Verdict.REFUTED, quantity="y"),
    )
    short, long, known = list(text_report(gated(*found, policy=policy)))[:3]

    assert short.endswith("a margin of 0.2: too few paths")
    assert long.endswith("long long ...")
    assert len(long) < 400
    assert known.startswith("failing as expected: plain on line, sharp y")
    assert known.endswith("a margin of 0.2: issue 12")


def test_words_without_an_interval():
    """A refutation that took no sampling says that there is no interval."""
    lines = list(text_report(gated(result(Verdict.REFUTED, method=Method("contract and exactness", 0), tier=0))))

    assert "  estimate: none, and no interval: no sampling was needed" in lines


def test_words_show_no_control_characters(everything):
    """Every line is printable, whatever names and reasons hold."""
    lines = list(text_report(gated(*everything, violations=(NASTY,), warnings=(NASTY,))))

    assert all(line.isprintable() for line in lines)
