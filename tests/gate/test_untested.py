"""Claims that nothing puts to the test."""

from dataclasses import replace
from typing import ClassVar

import pytest

from facade import CellResult, Policy, gate_plan
from sdaeverify import on_request
from sdaeverify.gate.untested import find_untested
from sdaeverify.measuring import Finding, Verdict

from .conftest import SHARP, Plain, added, line, registered


def of(*claims):
    """Return a scheme with these claims."""

    class Bold(Plain):
        name: ClassVar[str] = "bold"

    Bold.claims = claims
    return Bold()


@on_request
def rare():
    return added()


def told(claims, quantities=("x",), families=(line,), verdict=Verdict.VERIFIED, **policy):
    """Return what is said of claims where each cell has findings of these quantities."""
    registry, chosen = registered((of(*claims),), families), Policy(**policy)
    plan = gate_plan(registry, chosen)
    findings = tuple(Finding(quantity=name, verdict=verdict) for name in quantities)
    found = find_untested(registry, chosen, plan, [CellResult(cell, findings) for cell in plan.cells])
    return [(each.why, each.chosen) for each in found]


def test_all_is_tested():
    """A claim with a cell, and its quantities with findings, is tested; one of no quantity needs none."""
    assert told([SHARP, replace(SHARP, quantities=("x", "y"))], quantities=("x", "y", "z")) == []


@pytest.mark.parametrize("claimed", ["x", "x@T"])
def test_a_quantity_at_the_end_is_tested_there(claimed):
    """A claim on the end, or on all times, is tested by a finding at the end."""
    assert told([replace(SHARP, quantities=(claimed,))], quantities=("x@T",)) == []


@pytest.mark.parametrize(
    ("claim", "why"),
    [
        (replace(SHARP, measure="sharpp"), "measure 'sharpp' is not registered; did you mean sharp?"),
        (replace(SHARP, quantities=("x", "energy")), "no result is about 'energy'; did you mean y-energy?"),
        (replace(SHARP, when=frozenset({"algebraic"})), "it applies to no selected problem"),
    ],
)
def test_what_counts(claim, why):
    """A measure or quantity that is unknown, or traits that no problem has, leave a claim untested."""
    ((said, chosen),) = told([SHARP, claim], quantities=("x", "y-energy"))

    assert said.startswith(why)
    assert not chosen


def test_what_the_policy_leaves_out():
    """A measure that is not selected and a problem on request are a policy's choice; its list of names is not."""
    added_only = replace(SHARP, when=frozenset({"additive-noise"}))

    assert told([SHARP, replace(SHARP, measure="blunt")], measures=("sharp",)) == [
        ("the policy does not select the measure", True)
    ]
    assert told([SHARP, added_only], families=(line, rare)) == [
        ("it applies only to problems run on request, such as rare", True)
    ]
    assert told([SHARP, added_only], families=(line, rare), problems=("line",)) == [
        ("it applies to no selected problem", False)
    ]


@pytest.mark.parametrize("verdict", [Verdict.ERROR, Verdict.NOT_RUN])
def test_what_is_not_known(verdict):
    """Where nothing was measured, or a scheme fails as a whole, the quantities are not known."""
    claim = replace(SHARP, quantities=("y",))

    assert told([claim], verdict=verdict) == []
    assert told([claim], quantities=("",)) == []


def test_one_problem_need_not_have_all_quantities():
    """At a tier that tests each claim once, one quantity of it is enough; none is not."""
    claim = replace(SHARP, quantities=("x", "v"))

    assert told([claim], tier="smoke") == []
    assert len(told([claim])) == 1
    assert len(told([claim], tier="smoke", quantities=("y",))) == 2
