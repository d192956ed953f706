"""Everything that is registered passes the kit: every scheme on every problem it can be put to, and every problem."""

import inspect

import pytest

from sdaeverify.forms import TRAITS
from sdaeverify.planted import Planted
from sdaeverify.registry import Registry
from sdaeverify.scheme import Scheme
from sdaeverify.specs import ProblemSpec
from sdaeverify.testing import check_scheme
from sdaeverify.testing.questions import Question
from sdaeverify.testing.traits import EVIDENCE


def passed(question: Question, *skipped: str) -> None:
    """Assert that a check passes, or that it is one of those that may have nothing to ask."""
    outcome = question.answer({})
    allowed = {"passed", "skipped"} if not skipped or outcome.check in skipped else {"passed"}

    assert outcome.status in allowed, outcome.reason


def test_a_scheme_passes(asked_of_scheme: Question) -> None:
    """What a scheme says of itself is true, and it is exact on trivial equations; some claim nothing."""
    passed(asked_of_scheme, "claims")


def test_a_scheme_passes_on_a_problem(asked_of_cell: Question) -> None:
    """A step keeps its contract on every problem it can be put to; none of the checks is skipped."""
    passed(asked_of_cell, "none of them")


def test_a_problem_passes(asked_of_problem: Question) -> None:
    """Derivatives, views, traits and truths of a problem are right, where it has them."""
    passed(asked_of_problem)


@pytest.mark.slow
def test_a_problem_passes_what_takes_long(asked_for_long: Question) -> None:
    """Controls are as declared, and truths of long problems agree with simulations."""
    passed(asked_for_long)


def test_a_shipped_scheme_describes_itself(shipped_scheme: Scheme) -> None:
    """Class and step have docstrings, and the scheme has a source of its own."""
    assert (type(shipped_scheme).__doc__ or "").strip()
    assert (type(shipped_scheme).step.__doc__ or "").strip()
    assert shipped_scheme.source.strip()


def test_a_planted_breach_fails_the_kit(planted: Planted) -> None:
    """What breaks the contract of a step, or is inexact on trivial equations, fails a check of behaviour."""
    rows = check_scheme(planted.scheme, [planted.problem])

    assert [row for row in rows if (row["category"], row["status"]) == ("behaviour", "failed")]


def test_a_scheme_without_claims_is_a_control(shipped_scheme: Scheme, negative: set[str]) -> None:
    """Only schemes that are there to be refuted claim nothing."""
    assert shipped_scheme.claims or shipped_scheme.name in negative


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
    assert EVIDENCE.keys() == TRAITS
