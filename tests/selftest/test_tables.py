"""The kill matrix as text."""

import io

import pytest
from rich.console import Console

from facade import kill_matrix, selftest_trial
from sdaeverify.measuring import Verdict
from sdaeverify_lab.selftest.kills import counts, in_words, kill_table, terminal_table

from .conftest import Bad, Good, bug


@pytest.fixture
def matrix(registry_of, result_of):
    """One bug refuted, one that survives, an equivalent change that is refuted, and a false alarm."""
    registry = registry_of(bug(), bug("sly"), bug("harmless", equivalent="it cancels"))
    results = [
        result_of(Bad(), Verdict.REFUTED),
        result_of(Bad("sly"), Verdict.INCONCLUSIVE, tier=3),
        result_of(Bad("harmless"), Verdict.REFUTED, tier=3),
        result_of(Good(), Verdict.REFUTED),
    ]
    return kill_matrix(selftest_trial(registry), results)


def test_table_has_a_row_for_each_bug_and_a_column_for_each_check(matrix):
    """A number under each check says whether it refutes the bug."""
    table = kill_table(matrix).set_index("bug")

    assert table["sharp T1"].to_dict() == {"a plain bug": 1, "a sly bug": 0, "a harmless bug": 0}
    assert table["sharp T3"].to_dict() == {"a plain bug": 0, "a sly bug": 0, "a harmless bug": 1}
    assert table["outcome"].to_dict() == {
        "a plain bug": "refuted",
        "a sly bug": "survives",
        "a harmless bug": "refuted though equivalent",
    }
    assert table.loc["a plain bug", ["scheme", "problem"]].tolist() == ["planted-bad", "line"]


def test_terminal_table_marks_what_refutes(matrix):
    """In the terminal, a mark stands in the row of the bug, in ASCII where nothing else can be shown."""
    console = Console(width=100, record=True, file=io.StringIO())
    console.print(terminal_table(matrix, plain=True))
    lines = {line.split("  ")[0]: line.split()[-2:] for line in console.export_text().splitlines() if "bug" in line}

    assert lines["a plain bug"] == ["x", "."]
    assert lines["a sly bug"] == [".", "."]


def test_everything_unexpected_is_told(matrix):
    """Survivors, refuted equivalents and false alarms have a line each, what came out right has none."""
    lines = [line.plain for line in in_words(matrix)]

    assert lines == [
        "survives: a sly bug (planted-bad[kind=sly] on line): sharp x inconclusive: inconclusive by tier 3",
        "refuted though equivalent: a harmless bug: sharp x refuted: refuted by tier 3",
        "false alarm: good on line, sharp x: refuted by tier 1",
        "1 of 2 planted bugs are refuted, 0 of 1 equivalent changes are not; "
        "of 1 findings on claims of registered schemes, 1 refuted",
    ]
    assert lines[-1] == counts(matrix)
