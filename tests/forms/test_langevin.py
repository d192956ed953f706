"""The Langevin form: its first-order system, what it passes on, and what it refuses."""

import numpy as np
import pytest

from forms.refusing import refusal
from sdaeverify import SDE, Angle, Chart, HolonomicSDAE, Langevin, Line, Moment

GAMMA, SIGMA = 0.3, 0.8


def force(q):
    """Return a force that couples the positions."""
    return -np.sin(q[::-1]) * q


def make(**changes):
    """Return a valid problem with some of its arguments changed."""
    valid = {"force": force, "friction": GAMMA, "strength": SIGMA, "position": [0.5, -1.0], "momentum": [0.0, 2.0]}
    return Langevin(**{**valid, "horizon": 1.0, "source": "made up", **changes})


def test_components_have_the_same_names_in_both_views():
    """Positions are q and momenta p, of the problem as of its system, which starts where it does."""
    problem, x = make(), np.arange(8.0).reshape(4, 2)

    for parts in (problem.parts(x), problem.view(SDE).parts(x)):
        assert {name: rows.tolist() for name, rows in parts.items()} == {"q": [[0, 1], [2, 3]], "p": [[4, 5], [6, 7]]}
    assert problem.initial(2).tolist() == [[0.5] * 2, [-1.0] * 2, [0.0] * 2, [2.0] * 2]
    assert np.array_equal(problem.view(SDE).initial(2), problem.initial(2))
    assert problem.state(x) is x


def test_everything_known_is_passed_on():
    """Observables, truths, chart, relaxation and noise of the system are the problem's own."""
    chart = Chart(axes=(Angle(), Line(0.0, 1.0)), embed=lambda z: z, read=lambda x: x)
    observables = {"p": lambda t, s: s["p"][0]}
    truths = (Moment(observable="p", value=lambda t: 0.0, source="made up"),)
    given = {"observables": observables, "truths": truths, "chart": chart, "relaxation_time": 3.0, "units": "none"}
    view = make(**given, noise=frozenset({"dW"})).view(SDE)

    assert {name: getattr(view, name) for name in given} == given
    assert (view.noise, view.horizon, view.noise_dim, view.seen_as) == ({"dW"}, 1.0, 2, "first-order system")


def test_the_noise_is_additive_by_its_form():
    """Traits that follow from the form need no declaration; one position makes the noise scalar."""
    additive = {"additive-noise", "vanishing-milstein-term", "commutative-noise"}
    assert make().traits == additive | {"unconstrained", "no-delay"}
    single = make(position=[0.5], momentum=[0.0])
    assert single.traits == make().traits | {"scalar-noise"}
    assert single.view(SDE).traits - {"linear-growth"} == single.traits


def test_views_are_itself_and_the_system():
    """It is offered as it is, as an SDE, and as nothing else; the Ito equation is the system."""
    problem = make()

    assert problem.view(Langevin) is problem
    assert isinstance(problem.ito(), SDE)
    assert problem.view(HolonomicSDAE) is None
    assert not problem.has_constraints


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"friction": -0.1}, "friction must be finite and not negative, got -0.1"),
        ({"friction": np.nan}, "friction must be finite and not negative, got nan"),
        ({"strength": np.inf}, "strength must be finite and not negative, got inf"),
        ({"momentum": [0.0]}, "momentum has 1 components, position has 2"),
        ({"force": lambda q: q[:1]}, "force(q) returned shape (1, 3), expected (2, 3) for 3 paths (paths last)"),
    ],
)
def test_contradictory_problems_are_refused_in_one_line(changes, message):
    """The message says what was expected and what was given."""
    assert message in refusal(make, **changes)
