"""Expected failures."""

import pytest

from sdaeverify.contracts.finding import Verdict
from sdaeverify.errors import UsageError
from sdaeverify.gate.policy import ExpectedFailure, expectation

from .conftest import Plain, result

FOUND = result(Verdict.REFUTED, scheme=Plain("odd"), quantity="Dg v")


@pytest.mark.parametrize(
    ("globs", "meant"),
    [
        ({}, True),
        ({"scheme": "plain[kind=odd]"}, True),
        ({"scheme": "plain"}, False),
        ({"scheme": "plain*"}, True),
        ({"scheme": "plain[kind=o?d]"}, True),
        ({"scheme": "[p]lain*"}, False),
        ({"problem": "li?e", "measure": "sharp", "quantity": "D* v"}, True),
        ({"problem": "plane"}, False),
        ({"quantity": "dg v"}, False),
    ],
)
def test_globs(globs, meant):
    """All globs must match whole labels; brackets stand for themselves."""
    expected = ExpectedFailure(reason="known", **globs)

    assert expected.matches(FOUND.cell, FOUND.findings[0]) is meant


def test_first_counts():
    """Of several that match the first one gives the reason."""
    entries = [ExpectedFailure(reason=str(n), quantity=glob) for n, glob in enumerate(("x", "D*", "*"))]

    assert expectation(FOUND.cell, FOUND.findings[0], entries) is entries[1]


def test_reason_is_required():
    """Nothing is expected to fail without a reason."""
    with pytest.raises(UsageError, match="scheme=x has no reason"):
        ExpectedFailure(reason=" ", scheme="x")
