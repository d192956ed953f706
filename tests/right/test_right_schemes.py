"""Unusual schemes that are right are not refuted, and their wrong twins are not verified."""

import pytest

from right import CASES
from sdaeverify import verify

pytestmark = pytest.mark.slow


def claimed(scheme, problems):
    """Return verdicts and reasons of all claims of a scheme, on problems and for classes of equations."""
    result = verify([scheme], problems.split(","), paths=1024)
    cells = result.verdicts[result.verdicts["claim"].fillna("") != ""]
    on_problems = zip(cells["verdict"].astype(str), cells["problem"], cells["reason"], strict=True)
    classes = result.classes
    for_classes = zip(classes["verdict"].astype(str), classes["class"], classes["first"], strict=True)
    return [*on_problems, *for_classes]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.scheme.name)
def test_right_one_is_not_refuted(case):
    """A claim that is true is not refuted."""
    rows = claimed(case.scheme(), case.problems)
    assert rows
    assert not [row for row in rows if row[0] in {"refuted", "error"}]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.scheme.name)
def test_wrong_twin_is_not_verified(case):
    """Some claim of the same scheme with one coefficient, sign or state changed is refuted or undecided."""
    rows = claimed(case.scheme(right=False), case.problems)
    assert any(verdict in {"refuted", "inconclusive"} for verdict, *_ in rows)
