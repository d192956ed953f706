"""Everything that is registered passes the kit: every scheme on every problem it can be put to, and every problem."""

import inspect
from collections.abc import Container

import pytest

from conformance.cells import Inquiry, cells, in_turn, is_late, schemes, specs
from facade import EVIDENCE, Planted, Registry, known_traits
from sdaeverify.testing import check_scheme, checks
from sdaeverify_bridges.kit import Bridge

OF_PROBLEMS = {check.name for check in checks("problem")}


def complaints(inquiry: Inquiry, may_be_skipped: Container[str] = ()) -> list[str]:
    """Return what fails, and what has nothing to ask where it should, check by check."""
    return [
        f"{row['check']} {row['status']}: {row['reason']}"
        for row in (question.answer() for question in inquiry.questions)
        if row["status"] != "passed" and not (row["status"] == "skipped" and row["check"] in may_be_skipped)
    ]


def test_a_scheme_passes(asked_of_scheme: Inquiry) -> None:
    """What a scheme says of itself is true, and it is exact on trivial equations; some claim nothing."""
    assert complaints(asked_of_scheme, {"claims"}) == []


@pytest.mark.slow
def test_claims_of_a_scheme_are_tested(asked_about_claims: Inquiry) -> None:
    """Each claim holds on a registered problem, where its quantities are measured; the gate tells it, too."""
    assert complaints(asked_about_claims, {"claims-tested"}) == []


def test_a_scheme_passes_on_a_problem(asked_of_cell: Inquiry) -> None:
    """A step keeps its contract on every problem; one that jumps with its noise is no power series in its size."""
    assert complaints(asked_of_cell, {"any-number-of-steps"}) == []


@pytest.mark.slow
def test_every_variant_passes_on_every_problem(asked_of_another_cell: Inquiry) -> None:
    """So it does with the parameters whose turn it is not among the fast tests."""
    assert complaints(asked_of_another_cell, {"any-number-of-steps"}) == []


def test_every_variant_has_its_turn(registry: Registry) -> None:
    """Each variant is put to some problem, each scheme by the fast tests, and each problem to some scheme."""
    everything = {cell.label for cell in cells(registry)}
    chosen, others = ({cell.label for cell in found} for found in in_turn(registry))

    assert everything == chosen | others
    assert not chosen & others
    assert {label.partition(" on ")[0] for label in chosen} == {scheme.label for scheme in schemes(registry)}
    fast = {label.partition(" on ")[0] for label in chosen if not is_late(label)}
    assert fast == {scheme.name for scheme in schemes(registry)}
    assert {label.partition(" on ")[2] for label in chosen} == {label.partition(" on ")[2] for label in everything}


def test_a_problem_passes(asked_of_problem: Inquiry) -> None:
    """Derivatives, views, traits and truths of a problem are right, where it has them."""
    assert complaints(asked_of_problem, OF_PROBLEMS) == []


@pytest.mark.slow
def test_a_problem_passes_what_takes_long(asked_for_long: Inquiry) -> None:
    """Controls are as declared, and truths of long problems agree with simulations."""
    assert complaints(asked_for_long, OF_PROBLEMS) == []


def test_a_shipped_scheme_describes_itself(registry: Registry) -> None:
    """Class and step have docstrings, and the scheme has a source of its own."""
    for scheme in schemes(registry):
        texts = (type(scheme).__doc__, type(scheme).step.__doc__, scheme.source)
        assert [bool((text or "").strip()) for text in texts] == [True] * 3, scheme.label


def test_a_planted_violation_fails_the_kit(planted: Planted) -> None:
    """What breaks the contract of a step, or is inexact on trivial equations, fails a check of behaviour."""
    rows = check_scheme(planted.scheme, [planted.problem], level=1)

    assert [row for row in rows if (row["category"], row["status"]) == ("behaviour", "failed")]


def test_a_scheme_without_claims_is_a_control(registry: Registry) -> None:
    """Only schemes that are there to be refuted claim nothing."""
    problems = [entry.make().build() for entry in registry.problems.values()]
    negative = {control.negative for problem in problems for control in problem.controls}
    # A bridge claims what its library documents, if anything.
    silent = {each.name for each in schemes(registry) if not each.claims and not isinstance(each, Bridge)}

    assert silent <= negative


def test_a_shipped_problem_describes_its_parameters(registry: Registry) -> None:
    """The function's docstring has every parameter and a source with units."""
    for entry in registry.problems.values():
        family = entry.make().function
        wanted = ["Source\n------", "unit", *(f"\n{each} : " for each in inspect.signature(family).parameters)]
        assert not [each for each in wanted if each not in (inspect.getdoc(family) or "")], entry.name


def test_a_shipped_problem_has_observables(registry: Registry) -> None:
    """There is something to take expectations of."""
    assert [spec.label for spec in specs(registry) if not spec.build().observables] == []


def test_every_trait_has_its_evidence() -> None:
    """No trait can be declared that is not checked."""
    assert EVIDENCE.keys() == known_traits().keys()
