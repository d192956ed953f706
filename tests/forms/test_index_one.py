"""Index-1 equations without delay: the delay form's in functions of t, x and y."""

from dataclasses import replace

import numpy as np
import pytest

from facade import Delayed, IndexOne, IndexOneTrees, StochasticTheta, partials
from forms.refusing import refusal
from sdaeverify import SDE, DelaySDAE, Increment, IndexOneSDAE, Partials

COMMON = {"algebraic": [0.5], "noise_dim": 1, "horizon": 1.0, "source": "a test"}


def plain(**changed):
    """Return dx = (y - x^2) dt + (x + y) dW, 0 = 2 y - x, with its derivatives."""
    given = {
        "drift": lambda t, x, y: y - x * x,
        "diffusion": lambda t, x, y: (x + y)[:, None],
        "constraint": lambda t, x, y: 2.0 * y - x,
        "start": [1.0],
        "drift_partials": lambda t, x, y: (-2.0 * x[None], np.ones((1, 1, x.shape[-1]))),
    }
    return IndexOneSDAE(**{**COMMON, **given, **changed})


def with_delay_form():
    """Return the same as a delay equation without delay."""
    return DelaySDAE(
        drift=lambda t, x, v, y: y - x * x,
        diffusion=lambda t, x, v, y: (x + y)[:, None],
        constraint=lambda t, x, v, y: 2.0 * y - x,
        delay=0.0,
        history=lambda t: [1.0],
        drift_partials=lambda t, x, v, y: Partials(-2.0 * x[None], 0.0 * x[None], np.ones((1, 1, x.shape[-1]))),
        **COMMON,
    )


@pytest.mark.parametrize("build", [plain, lambda: replace(plain(), horizon=2.0)])
def test_step_is_that_of_the_delay_form(build):
    """A scheme for the delay form makes the same step, to the last bit; a copy is made of what was given."""
    problem, other, scheme = build(), with_delay_form(), StochasticTheta(theta=0.5)
    noise = Increment(0.1 * np.arange(3.0)[None], None)

    ours, theirs = (scheme.step(each, scheme.start(each, 3, 0.1), 0.0, 0.1, noise).state for each in (problem, other))

    assert all(np.array_equal(a, b) for a, b in zip(ours, theirs, strict=True))
    assert problem.traits == other.traits


def test_it_offers_what_it_has():
    """It has algebraic components and no delay, and is an SDE to those who ask for one."""
    problem = plain()

    assert problem.capability(Delayed) is None
    assert problem.why_not(Delayed) == "an IndexOneSDAE has no delay"
    assert problem.capability(IndexOne) is problem
    assert isinstance(problem.view(SDE), SDE)


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({"drift": lambda t, x, y: x[0]}, "drift(t, x, y) returned shape"),
        ({"algebraic": [0.6]}, "violates constraint = 0"),
        ({"constraint": lambda t, x, y: 0.0 * y + x - 1.0, "algebraic": [0.0]}, "singular at the start"),
        ({"drift_partials": lambda t, x, y: (x[None], np.ones((1, 1, x.shape[-1])))}, "drift_partials"),
    ],
)
def test_mistakes_are_told(changed, text):
    """A shape, a start, an index and a derivative that are wrong are errors of one line."""
    assert text in refusal(plain, **changed)


def test_schemes_call_it_in_the_variables_of_its_author():
    """Functions of (t, x, y) are called so, or with the lagged value before y as schemes for delay equations do."""
    problem = plain(solved=lambda t, x: 0.5 * x)
    x, y, w = np.array([[1.0, 3.0]]), np.array([[0.5, 2.0]]), np.array([[0.1, -0.2]])

    for name in ("drift", "diffusion", "constraint"):
        function = getattr(problem, name)
        assert np.array_equal(function(0.0, x, y), function(0.0, x, x, y))
    assert np.array_equal(problem.drift(0.0, x, y), y - x * x)
    assert np.array_equal(problem.diffused(0.0, x, y, w), (x + y) * w)
    assert np.array_equal(problem.diffused(0.0, x, x, y, w), (x + y) * w)
    assert np.array_equal(problem.eliminated(0.0, x), problem.eliminated(0.0, x, x))
    assert np.array_equal(plain().eliminated(0.0, x), 0.5 * x)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e6, 1e12])
def test_derivatives_are_checked_in_any_unit(unit):
    """Right derivatives of a constraint that is 0 at a far start are accepted, those off by a thousandth are not."""
    of_x = {"start": [2.0 * unit], "algebraic": [unit], "drift_partials": None}

    def derivatives(factor):
        return lambda t, x, y: (-factor * np.ones((1, 1, x.shape[-1])), 2.0 * np.ones((1, 1, x.shape[-1])))

    assert plain(**of_x, constraint_partials=derivatives(1.0)).algebraic[0] == unit
    wrong = refusal(plain, **of_x, constraint_partials=derivatives(1.001))
    assert wrong.startswith("constraint_partials(t, x, v, y).x disagrees with a difference quotient")


@pytest.mark.parametrize("additive", [True, False])
def test_related_equations_have_the_derivatives_of_their_coefficients(additive):
    """Equations that affine maps relate, near and far out, give the derivatives that complex steps find."""
    trees = IndexOneTrees(IndexOneSDAE, additive=additive)
    rng = np.random.default_rng(5)
    for pair in (trees.relatives(2), *trees.distant(2)[:4]):
        for problem in (pair.above, pair.below):
            at = problem.initial(3)
            x, y = (part + rng.standard_normal(part.shape) for part in (at.x, at.y))
            for f, given in (
                (problem.drift, problem.drift_partials),
                (problem.constraint, problem.constraint_partials),
            ):
                found, expected = given(0.7, x, x, y), partials(f, 0.7, x, x, y)
                assert all(np.allclose(*each, rtol=1e-10, atol=1e-10) for each in zip(found, expected, strict=True))
