"""Sets that solutions do not leave, and what of them problems and schemes say."""

import numpy as np
import pytest

from facade import ProblemSpec, ProblemSubject, check_traits, cir, gbm, load_plugins
from sdaeverify import SDE, Claim, DelaySDAE, Domain, ProblemError, SchemeError, Trait
from sdaeverify.forms import why_not_within
from sdaeverify.forms.delay.linked import linked_equation
from sdaeverify.probing import cloud

DOMAINS = {
    "orthant": Domain.orthant(),
    "box": Domain.box([0.0, -1.0], [1.0, 2.0]),
    "interval": Domain.box(0.0, 1.0),
    "simplex": Domain.simplex(),
    "ball": Domain.ball(2.0),
}
OUTSIDE = {"orthant": -1.0, "box": 3.0, "interval": 1.5, "simplex": 0.7, "ball": 1.5}
GIVEN = {
    "drift": lambda t, x: -x,
    "diffusion": lambda t, x: 0.0 * x[:, None],
    "noise_dim": 1,
    "horizon": 1.0,
    "source": "a test",
}


@pytest.mark.parametrize("name", DOMAINS)
def test_samples_are_inside_and_a_state_outside_is_not(name):
    """What a domain samples it contains, and a state far out it does not."""
    domain = DOMAINS[name]
    x = domain.draw(2, 100)
    assert x.shape == (2, 100)
    assert domain.contains(x).all()
    assert np.ptp(x, axis=1).min() > 0.1
    assert not domain.contains(np.full((2, 1), OUTSIDE[name])).any()


@pytest.mark.parametrize("name", DOMAINS)
def test_the_way_to_a_state_outside_ends_at_the_boundary(name):
    """The farthest state is inside, and a little farther is outside."""
    domain = DOMAINS[name]
    x, y = domain.draw(2, 10), np.full((2, 10), OUTSIDE[name])
    end = domain.farthest(x, y)
    assert domain.contains(end).all()
    assert not domain.contains(end + 1e-6 * (y - x)).any()
    assert np.array_equal(domain.farthest(x, x), x)


def test_a_solution_and_its_past_are_both_inside():
    """A delay equation as one without delay has the domain of both blocks."""
    twice = Domain.box([0.0, -1.0], [1.0, 2.0]).repeated(2)
    x = twice.draw(4, 50)
    assert twice.contains(x).all()
    assert not twice.contains(x + np.array([[0.0], [0.0], [0.0], [9.0]])).any()
    problem = DelaySDAE(
        drift=lambda t, x, v, y: 0.3 * (v - x),
        diffusion=lambda t, x, v, y: 0.4 * np.sqrt(np.maximum(x, 0.0))[:, None],
        delay=0.3,
        history=lambda t: [1.0 + t],
        noise_dim=1,
        horizon=1.0,
        source="a test",
        domain=Domain.orthant(),
    )
    equation = linked_equation(problem, 2, 2.0)
    assert equation.dimension == 2
    assert (cloud(equation, equation) >= 0.0).all()


def test_a_state_outside_is_replaced_by_the_one_before():
    """States inside stay as they are."""
    kept = Domain.orthant().keep(np.array([[1.0, -1.0]]), np.array([[2.0, 3.0]]))
    assert kept.tolist() == [[1.0, 3.0]]


def test_a_start_outside_is_refused():
    """A problem begins in its domain."""
    with pytest.raises(ProblemError, match=r"the start \[-1.0\] is not in the domain, x >= 0"):
        SDE(**GIVEN, start=[-1.0], domain=Domain.orthant())


def test_a_sampler_that_leaves_its_own_set_is_refused():
    """A predicate and its sampler agree."""
    wrong = Domain("x >= 0", lambda x: (x >= 0.0).all(axis=0), lambda rng, d, count: -np.ones((d, count)))
    with pytest.raises(ProblemError, match="sample returns states that contains rejects"):
        SDE(**GIVEN, start=[1.0], domain=wrong)


def test_something_else_in_its_place_is_refused():
    """A domain is a Domain, and the message says how to have one."""
    with pytest.raises(ProblemError, match=r"domain must be a Domain, such as Domain.orthant\(\), got 'half line'"):
        SDE(**GIVEN, start=[1.0], domain="half line")


def test_a_domain_at_or_above_0_sets_the_trait():
    """Claims may ask for it by name, and a problem without domain lacks it."""
    claim = Claim(measure="weak", value=1.0, source="a test", when=frozenset({"nonnegative"}))
    assert claim.when <= cir().traits
    assert not claim.when <= SDE(**GIVEN, start=[1.0]).traits
    assert "nonnegative" not in SDE(**GIVEN, start=[0.5], domain=Domain.box(-1.0, 1.0)).traits


@pytest.mark.parametrize("domain", [None, Domain.box(-1.0, 1.0)])
def test_a_stated_trait_needs_the_domain(domain):
    """The kit finds a problem that states the trait without a domain at or above 0."""
    problem = SDE(**GIVEN, start=[0.5], domain=domain, traits=frozenset({"nonnegative"}))
    subject = ProblemSubject(ProblemSpec("planted", lambda: problem), load_plugins())
    assert check_traits(subject) == "trait nonnegative is false: its domain does not say so"


def test_a_domain_lies_in_another_one():
    """A box in the orthant serves a scheme for the orthant, one around 0 does not, nor does no domain."""
    inside, around = (SDE(**GIVEN, start=[0.5], domain=Domain.box(low, 1.0)) for low in (0.0, -1.0))
    orthant = Domain.orthant()
    assert why_not_within(inside, orthant) == ""
    assert why_not_within(around, orthant) == "requires states with x >= 0; those of the problem have -1 <= x <= 1"
    plain = SDE(**GIVEN, start=[0.5])
    assert why_not_within(plain, orthant) == "requires states with x >= 0, and the problem declares no domain"
    assert why_not_within(plain, None) == ""


def test_growth_is_looked_at_in_the_domain():
    """A drift that grows quadratically for x >= 0 has no linear growth there, and one for x < 0 alone has."""

    def sde(drift):
        return SDE(**{**GIVEN, "drift": drift}, start=[1.0], domain=Domain.orthant())

    assert "linear-growth" not in sde(lambda t, x: -x * np.maximum(x, 0.0)).traits
    assert "linear-growth" in sde(lambda t, x: -x * np.minimum(x, 0.0)).traits
    assert "linear-growth" in cir().traits


def test_gbm_stays_where_it_starts():
    """A positive start stays positive; a negative one has no domain."""
    assert gbm().domain is not None
    assert gbm(x_0=-1.0).domain is None


def test_an_unknown_trait_is_told_how_to_be_declared():
    """A misspelt trait names the one that may be meant, and how to declare one of one's own; that is no error."""
    with pytest.raises(
        ProblemError, match=r"did you mean nonnegative\?; to declare .* give Trait\('nonegative', meaning\)"
    ):
        SDE(**GIVEN, start=[1.0], traits=frozenset({"nonegative"}))
    with pytest.raises(SchemeError, match=r"to declare one of your own, give Trait\('heated', meaning\)"):
        Claim(measure="weak", value=1.0, source="a test", when=frozenset({"heated"}))
    heated = Trait("heated", "A heat bath drives it.")
    problem = SDE(**GIVEN, start=[1.0], traits=frozenset({heated}))
    assert Claim(measure="weak", value=1.0, source="a test", when=frozenset({heated})).when <= problem.traits
