"""What a problem offers is asked for by kind, and facts of it are traits_hold by those who need them."""

import pickle

import numpy as np
import pytest

from facade import (
    Delayed,
    ProblemSpec,
    ProblemSubject,
    affine_constraint,
    check_traits,
    delay_test,
    gbm,
    known_traits,
    load_plugins,
    pendulum,
)
from sdaeverify import SDE, Claim, Problem, ProblemError, SchemeError, Trait
from sdaeverify.probing import Multiplied, StiffnessFamily

GIVEN = {
    "drift": lambda t, x: -x,
    "diffusion": lambda t, x: 1.0 + 0.0 * x[:, None],
    "start": [1.0],
    "noise_dim": 1,
    "horizon": 1.0,
    "source": "a test",
}


def pushed_outwards(problem):
    """Return "no" where the drift at 1 is not negative."""
    return "" if problem.drift(0.0, np.ones((1, 1))) < 0.0 else "no"


STABLE = Trait("contracting", "x f(x) < 0.", pushed_outwards)


class Energy:
    """A kind that nobody but a third party knows."""

    absent = "has no energy"


class Spring(SDE, Energy):
    """A form of theirs that offers it."""


@pytest.mark.parametrize(
    ("build", "kind"), [(delay_test, Delayed), (pendulum, Multiplied), (affine_constraint, StiffnessFamily)]
)
def test_form_offers_itself_where_it_has_what_is_asked_for(build, kind):
    """Delay, multipliers and stiffness parameters are found by kind; who has none says so."""
    problem = build()

    assert problem.capability(kind) is problem
    assert problem.why_not(kind) == ""
    assert gbm().capability(kind) is None
    assert gbm().why_not(kind) == f"an SDE {kind.absent}"


def test_third_party_adds_a_kind():
    """A kind that the framework never heard of is offered by the form that derives from it, and by no other."""
    spring = Spring(**GIVEN)

    assert spring.capability(Energy) is spring
    assert gbm().why_not(Energy) == "an SDE has no energy"


def test_third_party_adds_a_trait():
    """A trait that is given as an object is known where it is asked for; by its name alone it is unknown."""
    problem = SDE(**GIVEN, traits=frozenset({STABLE}))
    claim = Claim(measure="strong", value=0.5, source="a test", when=frozenset({STABLE}))

    assert claim.when <= problem.traits
    assert pickle.loads(pickle.dumps(STABLE)) == STABLE == "contracting"
    with pytest.raises(ProblemError, match="unknown traits"):
        SDE(**GIVEN, traits=frozenset({"contracting"}))
    with pytest.raises(SchemeError, match="unknown traits"):
        Claim(measure="strong", value=0.5, source="a test", when=frozenset({"contracting"}))


@pytest.mark.parametrize(("sign", "text"), [(-1.0, ""), (1.0, "trait contracting is false: no")])
def test_kit_asks_the_evidence_of_a_trait(sign, text):
    """What its author evaluates against a trait is a check of the kit."""
    problem = SDE(**{**GIVEN, "drift": lambda t, x: sign * x}, traits=frozenset({STABLE}))

    assert check_traits(ProblemSubject(ProblemSpec("planted", lambda: problem), load_plugins())) == text


def test_form_declares_its_traits():
    """What a class of a form declares can be stated by name; all that is traits_hold has a meaning."""

    class Charged(Problem):
        declared_traits = (Trait("charged", "It has a charge."),)

    assert set(known_traits(Charged)) - set(known_traits()) == {"charged"}
    assert "charged" in Charged(horizon=1.0, noise_dim=1, source="a test", traits=frozenset({"charged"})).traits
    assert all(trait.meaning.endswith(".") for trait in known_traits(Charged).values())
