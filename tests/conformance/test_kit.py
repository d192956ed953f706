"""Everything that is registered passes the kit: every scheme on every problem it can be put to, and every problem."""

import inspect
from collections.abc import Container

import pytest

from conformance.cells import Inquiry
from sdaeverify.bridges import Bridge
from sdaeverify.contracts.planted import Planted
from sdaeverify.contracts.scheme import Scheme
from sdaeverify.contracts.specs import ProblemSpec
from sdaeverify.forms import known_traits
from sdaeverify.registry.load import Registry
from sdaeverify.testing import check_scheme
from sdaeverify.testing.checks.traits import EVIDENCE
from sdaeverify.testing.table import checks

OF_PROBLEMS = {check.name for check in checks("problem")}


def complaints(inquiry: Inquiry, may_be_skipped: Container[str] = ()) -> list[str]:
    """Return what fails, and what has nothing to ask where it should, check by check."""
    outcomes = [question.answer({}) for question in inquiry.questions]
    wrong = [
        outcome
        for outcome in outcomes
        if outcome.status != "passed" and not (outcome.status == "skipped" and outcome.check in may_be_skipped)
    ]
    return [f"{outcome.check} {outcome.status}: {outcome.reason}" for outcome in wrong]


def test_a_scheme_passes(asked_of_scheme: Inquiry) -> None:
    """What a scheme says of itself is true, and it is exact on trivial equations; some claim nothing."""
    assert complaints(asked_of_scheme, {"claims", "claims-tested"}) == []


def test_a_scheme_passes_on_a_problem(asked_of_cell: Inquiry) -> None:
    """A step keeps its contract on every problem it can be put to; none of the checks is skipped."""
    assert complaints(asked_of_cell) == []


def test_a_problem_passes(asked_of_problem: Inquiry) -> None:
    """Derivatives, views, traits and truths of a problem are right, where it has them."""
    assert complaints(asked_of_problem, OF_PROBLEMS) == []


@pytest.mark.slow
def test_a_problem_passes_what_takes_long(asked_for_long: Inquiry) -> None:
    """Controls are as declared, and truths of long problems agree with simulations."""
    assert complaints(asked_for_long, OF_PROBLEMS) == []


def test_a_shipped_scheme_describes_itself(shipped_scheme: Scheme) -> None:
    """Class and step have docstrings, and the scheme has a source of its own."""
    assert (type(shipped_scheme).__doc__ or "").strip()
    assert (type(shipped_scheme).step.__doc__ or "").strip()
    assert shipped_scheme.source.strip()


def test_a_planted_violation_fails_the_kit(planted: Planted) -> None:
    """What breaks the contract of a step, or is inexact on trivial equations, fails a check of behaviour."""
    rows = check_scheme(planted.scheme, [planted.problem])

    assert [row for row in rows if (row["category"], row["status"]) == ("behaviour", "failed")]


def test_a_scheme_without_claims_is_a_control(shipped_scheme: Scheme, negative: set[str]) -> None:
    """Only schemes that are there to be refuted claim nothing."""
    is_bridge = isinstance(shipped_scheme, Bridge)  # it claims what its library documents, if anything
    assert shipped_scheme.claims or is_bridge or shipped_scheme.name in negative


@pytest.fixture(scope="session")
def negative(registry: Registry) -> set[str]:
    """Return the schemes that are there to be refuted."""
    problems = [entry.make().build() for entry in registry.problems.values()]
    return {control.negative for problem in problems for control in problem.controls}


def test_a_shipped_problem_describes_its_parameters(shipped_spec: ProblemSpec) -> None:
    """The function's docstring has every parameter and a source with units."""
    text = inspect.getdoc(shipped_spec.family) or ""

    assert "Source\n------" in text
    assert "unit" in text
    for parameter in inspect.signature(shipped_spec.family).parameters:
        assert f"\n{parameter} : " in text


def test_a_shipped_problem_has_observables(shipped_spec: ProblemSpec) -> None:
    """There is something to take expectations of."""
    assert shipped_spec.build().observables


def test_every_trait_has_its_evidence() -> None:
    """No trait can be declared that is not checked."""
    assert EVIDENCE.keys() == known_traits().keys()
