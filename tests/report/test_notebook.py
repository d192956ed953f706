"""A result at a prompt and in a notebook."""

import pytest

from report.rows import read, verdict, weak
from sdaeverify import UsageError
from sdaeverify.report.notebook import CellView, result_html, result_text

HOSTILE = "<script>alert(1)</script>\x1b[31m"


def rows():
    """Return a verified row and one without information."""
    return read(verdict(), weak())


ABSENT = [verdict(measure="drift", reason="the problem has no constraint")]


def test_a_result_is_short_at_a_prompt():
    """The counts, and the schemes by measure; nothing of thousands of characters."""
    told = result_text(read(*(verdict(scheme=f"s{n}") for n in range(300))))
    assert told.startswith("300 quantities: 300 verified")
    assert len(told.splitlines()) <= 40


def test_a_result_shows_itself_as_html():
    """A table with claim, margin, both orders and tier, what needs attention first."""
    told = result_html(read(verdict(), verdict(scheme="bad", verdict="refuted")))
    assert told.index("bad") < told.index("some-euler")
    cells = "<td>≥ 0.5</td><td>0.48</td><td>0.39 [0.36, 0.43]</td><td>0.3</td><td>T1</td>"
    assert cells in "".join(line.strip() for line in told.splitlines())


def test_a_cell_says_why():
    """At a prompt and in a notebook: what was found, and why the rest does not apply."""
    view = CellView.of(rows(), ABSENT, "some-euler", "gbm")
    for told in (repr(view), view._repr_html_()):
        assert "drift does not apply: the problem has no constraint" in told
        assert "14.05" not in told


def test_names_are_texts():
    """What a plugin is named is shown, and does nothing."""
    odd = read(verdict(scheme=HOSTILE, reason=HOSTILE))
    for told in (result_html(odd), CellView.of(odd, [], HOSTILE, "gbm")._repr_html_()):
        assert "<script>" not in told
        assert "\x1b" not in told
    assert "\x1b" not in result_text(odd) + repr(CellView.of(odd, [], HOSTILE, "gbm"))


def test_a_cell_that_is_not_there_is_an_error_of_the_user():
    """One line with the names."""
    with pytest.raises(UsageError, match="the result has no cell of 'a' on 'b'"):
        CellView.of(rows(), [], "a", "b")
