"""Expected failures."""

import pytest

from facade import FailingClaim, Policy, outcomes
from sdaeverify import UsageError
from sdaeverify.measuring import Verdict

from .conftest import Plain, result

FOUND = result(Verdict.REFUTED, scheme=Plain("odd"), quantity="Dg v")


@pytest.mark.parametrize(
    ("globs", "meant"),
    [
        ({}, True),
        ({"scheme": "plain[kind=odd]"}, True),
        ({"scheme": "plain*"}, True),
        ({"problem": "li?e", "measure": "sharp", "quantity": "D* v"}, True),
        ({"problem": "plane"}, False),
    ],
)
def test_globs(globs, meant):
    """All globs must match whole labels; brackets stand for themselves."""
    expected = FailingClaim(reason="known", **globs)

    (outcome,) = outcomes([FOUND], Policy(expected_failures=(expected,)))

    assert outcome.expected == ("known" if meant else "")


def test_first_counts():
    """Of several that match the first one gives the reason."""
    entries = tuple(FailingClaim(reason=glob, quantity=glob) for glob in ("x", "D*", "*"))

    assert outcomes([FOUND], Policy(expected_failures=entries))[0].expected == "D*"


def test_reason_is_required():
    """Nothing is expected to fail without a reason."""
    with pytest.raises(UsageError, match="scheme=x has no reason"):
        FailingClaim(reason=" ", scheme="x")
