"""A scheme of exactly one form is given problems of that form alone: trivial ones, members and those of trees."""

from typing import Any, ClassVar

import pytest
from hypothesis import given, settings

from facade import Examined, exactness_violation, member_classes, probe_of, tree_classes_of
from sdaeverify import (
    SDE,
    Claim,
    ConstrainedLangevin,
    DelaySDAE,
    HolonomicSDAE,
    IndexOneSDAE,
    Langevin,
    Problem,
    Scheme,
)
from sdaeverify_hunt.strategies import EXAMPLES

FORMS = (SDE, Langevin, IndexOneSDAE, DelaySDAE, HolonomicSDAE, ConstrainedLangevin)


class Circuit(IndexOneSDAE):
    """A form of somebody who derives it from another one."""


def recorder(of: type[Problem]) -> Any:
    """Return a scheme of a form that refuses each problem and notes it."""

    class Recorder(Scheme):
        name: ClassVar[str] = f"recorder-{of.__name__.lower()}"
        form: ClassVar[type[Problem]] = of
        claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=0.5, source="made up"),)
        seen: ClassVar[list[Problem]] = []

        def refuses(self, problem: Problem) -> str:
            self.seen.append(problem)
            return "noted"

    return Recorder()


@pytest.mark.sweep
@pytest.mark.parametrize("form", [*FORMS, Circuit], ids=lambda form: form.__name__)
def test_trivial_problems_members_and_trees_are_of_the_form(form: type[Problem]) -> None:
    """What is put to a scheme of a form in T0, as a member and for order conditions is an instance of the form."""
    scheme = recorder(form)
    exactness_violation(scheme)
    trivial = len(scheme.seen)
    member_classes(scheme, 1)
    for kind in tree_classes_of(scheme):
        _ = Examined(probe_of(scheme, kind, kind.motions or 2, 3)).why_not
    assert all(isinstance(problem, form) for problem in scheme.seen)
    assert bool(trivial) == (form is not Circuit)


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.__name__)
def test_trivial_problems_and_members_are_of_no_other_form(form: type[Problem]) -> None:
    """Trivial problems and members are of exactly the form, those of index 1 without delay."""
    trivial = [each.problem for variants in form.trivial_problems() for each in variants]
    members = [kind.member(1, 0) for kind in form.generic_classes()]
    assert trivial
    assert {type(problem) for problem in (*trivial, *members)} == {form}
    if form is IndexOneSDAE:
        assert not any(problem.delay for problem in (*trivial, *members))


@pytest.mark.sweep
@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.__name__)
def test_problems_of_hunts_are_of_the_form(form: type[Problem]) -> None:
    """An example that a hunt draws of a form is of exactly this form."""

    @settings(max_examples=10, database=None)
    @given(EXAMPLES[form.__name__].strategy())
    def draw(example: Any) -> None:
        assert type(example.build()) is form

    draw()
