"""Examples are what they say by construction, and their source makes them again."""

import importlib.util
from dataclasses import replace
from functools import reduce

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from facade import load_file, load_registry, select_problems
from sdaeverify import DelaySDAE
from sdaeverify.errors import PluginError
from sdaeverify_hunt import strategies
from sdaeverify_hunt.strategies import EXAMPLES, STATIONARY, Term, sdes, shipped
from sdaeverify_hunt.strategies.holonomic import EPS
from sdaeverify_hunt.strategies.terms import COS

pytestmark = pytest.mark.long

FEW = settings(
    max_examples=25, deadline=None, database=None, suppress_health_check=list(HealthCheck), derandomize=True
)
DRAWN = st.one_of(*(drawing.strategy() for drawing in (EXAMPLES | STATIONARY).values()))
STEP = 1e-6


def rows_of(coefficient):
    """Return the sums of terms that a vector or a matrix of them has."""
    deep = bool(coefficient) and any(not isinstance(term, Term) for each in coefficient for term in each)
    return [field for column in coefficient for field in column] if deep else coefficient


def values(problem):
    """Return start and coefficients of a problem, at two times and some states."""
    if isinstance(problem, DelaySDAE):
        x, y = (part + 0.1 * np.arange(3) for part in problem.initial(3))
        u = (problem.constraint,) if problem.constraint else ()
        return [*problem.initial(1), *(each(t, x, x, y) for t in (0.0, 0.3) for each in (problem.drift, *u))]
    equation = problem.equation()
    x = equation.initial(3)
    return [x, *(each for t in (0.0, 0.3) for each in problem.coefficients(t, x))]


@FEW
@given(strategies.overdamped())
def test_overdamped_examples_are_families(example):
    """Claims for all eps ask an example for its problem with another one: the rest of it is the same."""
    one, other = example.build(), example.build().member(0.25)

    assert (one.eps, other.eps) == (example.eps, 0.25)
    np.testing.assert_array_equal(one.drift(one.initial(3)), other.drift(one.initial(3)))


@FEW
@given(strategies.gradients())
def test_the_means_of_a_gradient_example_are_those_of_its_density(example):
    """The density exp((2/sigma^2) int f) has the declared means, by another quadrature of the drift."""
    problem = example.build()
    x = np.linspace(-16.0, 16.0, 40001)
    f = problem.drift(0.0, x[None])[0]
    exponent = 2.0 / example.strength**2 * np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * np.diff(x))])
    weights = np.exp(exponent - exponent.max())
    wanted = {"x": x, "x^2": x**2, "cos x": np.cos(x)}

    for truth in problem.truths:
        mean = weights @ wanted[truth.observable] / weights.sum()
        # The trapezoidal rule is off by (dx)^2/12 of the curvature.
        assert truth.value == pytest.approx(mean, abs=1e-5)
        assert problem.observables[truth.observable](0.0, {"x": x[None, :3]}).shape == (3,)


def test_a_term_is_written_as_python():
    """What is zero or one is left out, and a constant is its angle's value."""
    assert (
        Term(0.5, (0.0, 1.0, -2.0), 1.5, 0.25).text(["x", "y", "z"]) == "0.5 * np.cos(y + -2.0 * z + 1.5 * t + 0.25)"
    )
    assert Term(0.5).text([]) == "0.5 * np.cos(0.0)"


@FEW
@given(DRAWN)
def test_the_source_of_an_example_is_a_plugin_with_the_same_problem(tmp_path_factory, example):
    """What a plugin file registers has the start and the coefficients of what the example builds."""
    file = tmp_path_factory.mktemp("plugin") / "counterexample.py"
    file.write_text(example.source, encoding="utf-8")
    made, loaded = example.build(), load_file(file).counterexample()

    assert type(made) is type(loaded)
    assert made.traits == loaded.traits
    for one, other in zip(values(made), values(loaded), strict=True):
        np.testing.assert_array_equal(one, other)


@FEW
@given(DRAWN)
def test_an_example_can_be_moved_and_doubled(example):
    """An example with another start, or with larger coefficients, is one of the same form and kind."""
    for other in (example.moved(), example.doubled()):
        assert type(other.build()) is type(example.build())
        assert other != example or (other.terms == 0 and other.start == example.start)
        assert other.kind == example.kind


@FEW
@given(DRAWN)
def test_an_example_does_without_terms(example):
    """What is dropped leaves a problem of the same form and traits, and all drops leave no cosine that is named."""
    least = reduce(type(example).dropped, example.simpler(), example)

    assert least.build().traits == example.build().traits
    assert least.terms <= example.terms
    left = {term.shape for name in example.sums for field in rows_of(getattr(least, name)) for term in field}
    assert COS not in left


@FEW
@given(sdes(kinds=("diagonal",), groups=("globally Lipschitz",)))
def test_diagonal_noise_depends_on_its_own_component(example):
    """The diffusion is diagonal, and an entry does not change with the other components."""
    problem, d = example.build(), example.dimension
    x = problem.initial(d) + np.eye(d)
    B = problem.diffusion(0.3, x)

    off = ~np.eye(d, dtype=bool)
    assert not B[off].any()
    for row in range(d):
        others = [path for path in range(d) if path != row]
        assert len(set(B[row, row, others].tolist())) <= 1


@FEW
@given(sdes(kinds=("commutative",), groups=("globally Lipschitz",)))
def test_commutative_noise_commutes(example):
    """DB_j B_k is DB_k B_j at the start and beside it."""
    problem = example.build()
    x = problem.initial(4) + 0.2 * np.arange(4)
    B = problem.diffusion(0.3, x)
    # Column k holds DB_j B_k of all j.
    turned = np.stack([problem.derivative_of_diffusion(0.3, x, B[:, k]) for k in range(problem.noise_dim)], axis=2)

    np.testing.assert_allclose(turned, np.swapaxes(turned, 1, 2), atol=1e-12)


@FEW
@given(EXAMPLES["IndexOneSDAE"].strategy())
def test_the_constraint_of_index_1_is_a_contraction_in_y(example):
    """|G_y| is at most 1/2: Newton's method finds y wherever x is."""
    problem = example.build()
    x, q = problem.initial(1).x, len(example.algebraic)
    y = np.linspace(-1.0, 1.0, 5) + 0.1 * np.arange(q)[:, None]
    wide = np.repeat(x, 5, axis=1)
    moved = [y + STEP * np.eye(q)[:, [row]] for row in range(q)]
    still = problem.constraint(0.3, wide, wide, y) + y
    rates = [(problem.constraint(0.3, wide, wide, to) + to - still) / STEP for to in moved]

    assert np.abs(np.stack(rates)).sum(axis=0).max() <= 0.5 + 1e-6


@FEW
@given(EXAMPLES["HolonomicSDAE"].strategy())
def test_the_normals_of_a_holonomic_constraint_are_independent(example):
    """The Gram matrix of the constraints is bounded below at the start and where their surface goes."""
    problem = example.build()
    r = np.asarray(problem.position)[:, None]
    J = problem.dg(r)[..., 0]

    assert np.linalg.eigvalsh(J @ J.T).min() > 0.1
    assert np.abs(J @ np.asarray(problem.velocity)).max() < 1e-10


@FEW
@given(EXAMPLES["HolonomicSDAE"].strategy(), st.integers(0, 2**32 - 1))
def test_a_declared_constraint_bound_is_one(example, seed):
    """No norm of (2.7) exceeds the declared C_g at points of the constraint's neighbourhood."""
    problem = example.build()
    assume(problem.constraint_bound is not None)
    n, rng = problem.dimension, np.random.default_rng(seed)
    axes = np.array([term.size for term in example.surface[0] if term.size])
    directions = rng.standard_normal((n, 50))
    scales = np.sqrt(axes @ np.square(example.start) / (axes @ directions**2))
    near = rng.standard_normal((n, 50))
    x = scales * directions + EPS * near / np.linalg.norm(near, axis=0)

    J = problem.dg(x)[0]
    push = np.linalg.solve(np.asarray(example.mass), J)
    G = (J * push).sum(axis=0)
    units = [np.broadcast_to(each[:, None], x.shape) for each in np.eye(n)]
    bends = [problem.d2g(x, each, each)[0] for each in units]
    # Derivatives of g by complex step and differences of them have an error of 1e-13 or so.
    largest = problem.constraint_bound * (1.0 + 1e-10)
    assert max(np.linalg.norm(push, axis=0).max(), G.max(), (1.0 / G).max()) <= largest
    assert np.abs(bends).max() <= largest


def test_a_registered_problem_gets_other_numbers(tmp_path):
    """Some of the drawn examples of a registered problem differ from it, and their source makes them again."""
    specs, seen = select_problems(load_registry([]), "ou"), set()

    @FEW
    @given(shipped(specs))
    def draw(example):
        seen.add(example.parameters)
        np.testing.assert_array_equal(values(example.build())[0], values(example.build())[0])

    draw()
    assert len(seen) > 5


def test_it_is_said_how_hypothesis_is_installed(monkeypatch):
    """Without hypothesis the examples say in one line what to install."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(PluginError, match=r"pip install 'sdaeverify\[hunt\]'"):
        importlib.reload(strategies)


@FEW
@given(sdes(groups=("other units",)))
def test_an_example_in_other_units_is_the_same_equation(example):
    """Drift and diffusion at y = scale x + shift, s = time t are scale/time f and scale/sqrt(time) B at x and t."""
    scale, shift, time = example.units
    made, plain = example.build(), replace(example, units=type(example.units)()).build()
    x, t = plain.initial(3) + 0.1 * np.arange(3), 0.3
    y, s = scale * x + shift, time * t
    size = np.abs(y).max() * np.finfo(float).eps * 100.0

    np.testing.assert_allclose(made.initial(1), scale * plain.initial(1) + shift)
    np.testing.assert_allclose(made.drift(s, y), scale / time * plain.drift(t, x), atol=size / time)
    np.testing.assert_allclose(
        made.diffusion(s, y), scale / np.sqrt(time) * plain.diffusion(t, x), atol=size / np.sqrt(time)
    )
    begun = example.begun_at({"x": tuple(y[:, 0])}, s)
    np.testing.assert_allclose(begun.start, x[:, 0], atol=size / abs(scale))
    np.testing.assert_allclose(begun.build().drift(0.0, y), made.drift(s, y), rtol=1e-9, atol=size / time)
