"""Schemes and problems find each other, or say why not."""

from typing import ClassVar

from facade import gbm, match, pendulum
from sdaeverify import SDE, HolonomicSDAE, Scheme


class Plain(Scheme):
    """A scheme for SDEs."""

    name: ClassVar[str] = "plain"
    form: ClassVar[type] = SDE


class Mechanical(Scheme):
    """A scheme for constrained mechanics."""

    name: ClassVar[str] = "mechanical"
    form: ClassVar[type] = HolonomicSDAE


class Bounded(Plain):
    """A scheme that wants bounded noise."""

    name: ClassVar[str] = "bounded"
    noise: ClassVar[frozenset[str]] = frozenset({"three-point"})


class Picky(Plain):
    """A scheme that refuses every problem."""

    name: ClassVar[str] = "picky"

    def refuses(self, problem):
        return "not to my taste"


def test_a_problem_of_the_form_is_given_as_it_is():
    """A scheme gets the very problem where the forms agree."""
    problem = pendulum()

    assert match(Mechanical(), problem).problem is problem


def test_a_constrained_problem_is_seen_as_its_inherent_sde():
    """A scheme for SDEs gets the inherent SDE, and the match says so."""
    found = match(Plain(), pendulum())

    assert isinstance(found.problem, SDE)
    assert found.view == "inherent SDE"


def test_a_form_without_the_view_is_refused():
    """An SDE is no constrained problem, and the reason names both forms."""
    assert match(Mechanical(), gbm()).reason == "needs a HolonomicSDAE; this problem is an SDE"


def test_noise_that_is_not_drawn_is_refused():
    """A scheme that declares other noise is refused with its name."""
    assert match(Bounded(), gbm()).reason == "needs noise three-point, which the problem does not declare"


def test_a_scheme_may_refuse():
    """A scheme's own reason is passed on."""
    assert match(Picky(), gbm()).reason == "not to my taste"
