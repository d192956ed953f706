"""Reports: JSON, a summary and words."""

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facade import FailingClaim, Policy, markdown_report
from sdaeverify import UsageError
from sdaeverify.contracts.finding import Status
from sdaeverify.gate.against import changes, read_gate
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
    told = markdown_report(gated(found, violations=(line,))).splitlines()
    first, last = (place for place, text in enumerate(told) if text.startswith("~"))

    assert told[first] == told[last] == "~~~~"
    assert told[last + 1 :] == ["", "</details>"]
    assert all(text.isprintable() for text in told)
    # Outside of the block texts of plugins are cells of tables, in which nothing is markup.
    tables = [text for text in told[:first] if text.startswith("|")]
    assert {text.replace("\\|", "").count("|") for text in tables if text.count("---") != 6} <= {3, 7}
    assert not any(letter in text for text in tables for letter in ("<", "`", "]("))


def test_summary_has_tables():
    """Claims that did not pass, schemes with their counts, and, against an earlier gate, what changed."""
    found = gated(result(Verdict.VERIFIED), result(Verdict.REFUTED, quantity="y", reason="Too low."))
    told = markdown_report(found)
    assert "| refuted | plain | line | sharp y | order >= 1.0 up to a margin of 0.2 | Too low. |" in told
    assert "| scheme | verified | refuted |" in told
    assert "| plain | 1 | 1 |" in told
    assert "What changed" not in told

    before = {outcome.key: Status.PASSED for outcome in found.outcomes}
    changed = replace(found, changes=changes(before, found.outcomes, narrowed=False))
    assert "| plain | line | sharp y | verified | **refuted** |" in markdown_report(changed)
    assert "changed: plain on line, sharp y: verified before, refuted now" in [*text_report(changed)]
    assert json_report(changed)["changes"] == [
        {
            "scheme": "plain",
            "problem": "line",
            "measure": "sharp",
            "quantity": "y",
            "before": "verified",
            "now": "refuted",
        }
    ]
    assert "No claim has another status than before." in markdown_report(replace(found, changes=()))


def test_what_is_new_or_gone_is_a_change():
    """A claim of one of the two gates alone; a selection does not make the others gone."""
    new, old = gated(result(Verdict.VERIFIED, quantity="new")).outcomes, gated(result(Verdict.REFUTED)).outcomes
    before = {outcome.key: outcome.status for outcome in old}

    told = [(each.key.quantity, each.before, each.now) for each in changes(before, new, narrowed=False)]
    assert told == [("new", "not gated", "verified"), ("x", "refuted", "not gated")]
    assert [each.key.quantity for each in changes(before, new, narrowed=True)] == ["new"]
    assert changes(before, old, narrowed=False) == ()


def test_an_earlier_gate_is_read(tmp_path):
    """Its statuses come back; a file that no gate has written, or none, is told in one line."""
    found = gated(result(Verdict.VERIFIED), result(Verdict.REFUTED, quantity="y"))
    file = tmp_path / "gate.json"
    file.write_text(json.dumps(json_report(found)))
    assert read_gate(tmp_path) == read_gate(file) == {outcome.key: outcome.status for outcome in found.outcomes}

    for text in ("{", "[]", '{"outcomes": [{}]}', '{"outcomes": [{"status": "odd"}]}', "\xff"):
        file.write_text(text)
        with pytest.raises(UsageError, match=r"--against: .* is not a gate\.json"):
            read_gate(tmp_path)
    with pytest.raises(UsageError, match="--against: cannot read"):
        read_gate(tmp_path / "missing")


def test_summary_of_many():
    """A long list is cut, and says so; a scheme has a row of counts."""
    lines = markdown_report(gated(*(result(Verdict.REFUTED, quantity=f"x{n}") for n in range(202)))).splitlines()

    assert "and 2 more that fail, see gate.json" in lines
    assert "| plain | 202 |" in lines
    assert "and 2 more, see gate.json" in lines


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
