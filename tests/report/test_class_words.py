"""Modified equations in words, from the table of classes of a run."""

import pytest

from facade import equation_lines
from sdaeverify.report.class_words import class_lines, class_notes, hint


def row(kind, terms, told="{}: weak order 1\\n    drift       f"):
    """Return a row of the table of classes, its line breaks written as in a file."""
    return {"class": kind, "modified": told.format(kind), "modified_terms": terms}


def test_classes_of_the_same_terms_share_one_equation():
    """The others are listed below it; rows of several measures of one class count once."""
    rows = [
        row("scalar", "b1: x"),
        row("scalar", "b1: x"),
        row("general", "b1: x"),
        row("ode", "f: y"),
        row("a", "", ""),
    ]

    assert [*equation_lines(rows)] == [
        "",
        "scalar: weak order 1",
        "    drift       f",
        "    the same for the class general",
        "",
        "ode: weak order 1",
        "    drift       f",
    ]


LEFT_OUT = "Milstein's correction is left out; order 0.5: the condition b1(b1) fails, found 0, wanted I"


@pytest.mark.parametrize(
    ("reason", "told"), [(f"{LEFT_OUT}.", f". {LEFT_OUT}"), ("", ": b1(b1): found 0, wanted I")], ids=["new", "old"]
)
def test_a_refuted_class_is_told_with_its_mistake(reason, told):
    """The reason says what a scheme leaves out or solves instead; in a run without reasons, the condition stands."""
    condition = {"first": "b1(b1)", "found": "0", "wanted": "I", "reason": reason, "claimed_order": "1.0"}
    rows = [{"scheme": "odd", "measure": "strong", "class": "scalar", "verdict": "refuted", **condition}]

    assert [*class_notes(rows)][1] == f"refuted: odd, strong for the class scalar{told}"
    assert hint(rows, "odd", "strong", "refuted") == f"refuted for the class scalar, too{told}"
    (line, *_) = class_lines(rows, 200)
    assert str(line) == f"  strong order 1 refuted for smooth equations of the class scalar{told}"
