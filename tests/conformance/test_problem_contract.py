"""What every registered problem says of itself is true."""

import inspect
from collections.abc import Callable

import numpy as np
import pytest

from conformance.cells import LENGTHS, Trait, at_the_start, equation, spread
from conformance.differences import FIRST_ERROR, SECOND_ERROR, first, second
from sdaeverify.arrays import Array
from sdaeverify.errors import ProblemError
from sdaeverify.forms import SDE, TRAITS, DelaySDAE, Dissipation, HolonomicSDAE, Problem
from sdaeverify.numerics import directional, jacobian, second_directional
from sdaeverify.specs import ProblemSpec
from sdaeverify.truths import InvariantMean
from sdaeverify_schemes.euler_maruyama import EulerMaruyama

PATHS = 12
EPS = np.finfo(float).eps
TIMES = (0.0, 0.37, 0.91)


def states(problem: Problem) -> Array:
    """Return states of the problem's view as an SDE along a pilot trajectory, shape (d, P)."""
    return spread(EulerMaruyama(), equation(problem), PATHS)


def directions(x: Array, count: int = 3) -> list[Array]:
    """Return unit vectors in random directions on each path."""
    vectors = np.random.default_rng(5).standard_normal((count, *x.shape))
    return list(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def assert_small(value: Array, bound: float, *terms: Array) -> None:
    """Assert that a number is a rounding error of terms that cancel."""
    assert np.max(np.abs(value), initial=0.0) <= bound * max(1.0, *(np.max(np.abs(term)) for term in terms))


def test_a_problem_describes_itself(spec: ProblemSpec) -> None:
    """The function's docstring has every parameter and a source with units; so has the problem."""
    text, problem = inspect.getdoc(spec.family) or "", spec.build()

    assert "Source\n------" in text
    assert "unit" in text
    for parameter in inspect.signature(spec.family).parameters:
        assert f"\n{parameter} : " in text
    assert problem.source.strip()
    assert problem.units.strip()


def test_a_problem_starts_where_its_constraints_hold(spec: ProblemSpec) -> None:
    """All residuals vanish at the initial state to rounding."""
    problem = spec.build()
    residuals = problem.residuals(at_the_start(problem))

    assert bool(residuals) == problem.has_constraints
    for value, scale in residuals.values():
        assert_small(value, 8 * EPS, scale)


@pytest.mark.parametrize("paths", [1, 3])
def test_observables_are_numbers_on_each_path(spec: ProblemSpec, paths: int) -> None:
    """Each observable gives one finite number for each path."""
    problem = spec.build()
    parts = problem.parts(problem.initial(paths))

    assert problem.observables
    for observable in problem.observables.values():
        value = observable(0.0, parts)
        assert value.shape == (paths,)
        assert np.isfinite(value).all()


def test_a_chart_reads_what_it_embeds(charted: ProblemSpec) -> None:
    """Coordinates are read from the state they make, angles up to a turn, and states without outputs come back."""
    problem = charted.build()
    chart, ito = problem.chart, problem.ito()
    z = np.random.default_rng(2).uniform(-2.5, 2.5, (len(chart.axes), PATHS))
    x = chart.embed(z)

    assert x.shape == (ito.dimension, PATHS)
    assert_small(chart.read(x) - z, 16 * EPS, z)
    assert_small(chart.embed(chart.read(x)) - x, 16 * EPS, x)
    for value, scale in problem.residuals(problem.ito().parts(x)).values():
        assert_small(value, 16 * EPS, scale)


def test_a_chart_covers_the_initial_state(charted: ProblemSpec) -> None:
    """The start is embedded again from the coordinates read from it."""
    problem = charted.build()
    x = problem.ito().initial(1)

    assert_small(problem.chart.embed(problem.chart.read(x)) - x, 16 * EPS, x)


def test_a_relaxation_time_is_given_where_an_invariant_law_is(spec: ProblemSpec) -> None:
    """A problem knows invariant means exactly if it says how long it takes to forget its start."""
    problem = spec.build()
    known = any(isinstance(truth, InvariantMean) for truth in problem.truths)

    assert known == np.isfinite(problem.relaxation)
    assert problem.relaxation > 0.0


def test_functions_are_the_same_on_one_path_and_on_many(spec: ProblemSpec) -> None:
    """Drift and diffusion of a path do not depend on the paths beside it."""
    view = equation(spec.build())
    x = states(view)
    for f in (view.drift, view.diffusion):
        together = np.broadcast_to(f(0.2, x), (*f(0.2, x).shape[:-1], PATHS))
        for p in range(PATHS):
            alone = f(0.2, x[:, p : p + 1])
            assert_small(alone[..., 0] - together[..., p], 8 * EPS, together)


def test_the_derivative_of_the_diffusion_is_one(spec: ProblemSpec) -> None:
    """DB(x) y agrees with complex steps and with differences."""
    view = equation(spec.build())
    x = states(view)
    for y in LENGTHS.get(spec.name, 1.0) * np.stack(directions(x)):
        DB, B = view.derivative_of_diffusion(0.2, x, y), view.diffusion(0.2, x)
        assert_small(DB - first(lambda z: view.diffusion(0.2, z), x, y), FIRST_ERROR, B, DB)
        assert_small(DB - directional(lambda z: view.diffusion(0.2, z), x, y), 64 * EPS, DB)


def test_the_jacobian_of_the_constraint_is_one(constrained: ProblemSpec) -> None:
    """Dg agrees with complex steps and with differences, on the manifold and beside it."""
    problem = constrained.build()
    r = states(problem)[: problem.dimension]
    Dg, g = problem.dg(r), problem.constraint(r)

    assert_small(Dg - jacobian(problem.constraint, r), 16 * EPS, Dg)
    for y in directions(r):
        change = np.einsum("mnp,np->mp", Dg, y)
        assert_small(change - first(problem.constraint, r, y), FIRST_ERROR, g, change)


def test_the_curvature_of_the_constraint_is_one(constrained: ProblemSpec) -> None:
    """D^2 g(y, z) agrees with complex steps and with differences, and is symmetric."""
    problem = constrained.build()
    r = states(problem)[: problem.dimension]
    y, z, _ = directions(r)
    bend = problem.d2g(r, y, z)

    assert_small(bend - problem.d2g(r, z, y), 16 * EPS, bend)
    # Truncation and rounding balance at 1e-12 there, times fourth derivatives along y and z of size 3.
    assert_small(bend - second_directional(problem.constraint, r, y, z), 1e-9, bend)
    for w in (y, z, y + z):
        assert_small(problem.d2g(r, w, w) - second(problem.constraint, r, w), SECOND_ERROR, bend)


def test_the_view_keeps_the_constraints(constrained: ProblemSpec) -> None:
    """Drift and diffusion of the inherent SDE leave Dg v unchanged, and dr = v dt, on and off the manifold."""
    problem = constrained.build()
    view, n = problem.view(SDE), problem.dimension
    x = states(problem)
    f, B = view.drift(0.2, x), np.broadcast_to(view.diffusion(0.2, x), (2 * n, problem.noise_dim, PATHS))
    Dg, v = problem.dg(x[:n]), x[n:]
    turning = problem.d2g(x[:n], v, v)

    assert np.array_equal(f[:n], v)
    assert not B[:n].any()
    assert_small(np.einsum("mnp,np->mp", Dg, f[n:]) + turning, 64 * EPS, turning, f)
    assert_small(np.einsum("mnp,nlp->mlp", Dg, B[n:]), 64 * EPS, B)


def test_the_view_moves_along_the_normals_only(constrained: ProblemSpec) -> None:
    """What the inherent SDE adds to force and noise is a combination of the constraints' gradients."""
    problem = constrained.build()
    n, l = problem.dimension, problem.noise_dim
    x = states(problem)
    r, v = x[:n], x[n:]
    mass = np.linalg.inv(problem.inverse_mass(np.eye(n)))
    view = problem.view(SDE)
    impulse = np.einsum("ij,jp->ip", mass, view.drift(0.2, x)[n:]) - problem.force(0.2, r, v)
    kicks = np.einsum("ij,jlp->ilp", mass, view.diffusion(0.2, x)[n:]) - problem.diffusion(0.2, r, v)
    gradients = np.moveaxis(problem.dg(r), -1, 0).swapaxes(1, 2)
    normal = gradients @ np.linalg.pinv(gradients)

    for added in (impulse[:, None], kicks.reshape(n, l, PATHS)):
        rest = np.einsum("pij,jlp->ilp", np.eye(n) - normal, added)
        assert_small(rest, 64 * EPS, added)


def is_scalar(problem: Problem) -> None:
    assert problem.noise_dim == 1


def is_additive(problem: Problem) -> None:
    x = states(problem)
    count = len(x) // 2
    own = isinstance(problem, HolonomicSDAE)
    arguments, diffusion = ((x[:count], x[count:]), problem.diffusion) if own else ((x,), equation(problem).diffusion)
    values = [diffusion(t, *arguments) for t in TIMES]
    assert all(np.array_equal(B, np.broadcast_to(values[0][..., :1], B.shape)) for B in values)


def is_diagonal(problem: Problem) -> None:
    view = problem.view(SDE)
    x = states(view)
    B = np.broadcast_to(view.diffusion(0.2, x), (len(x), len(x), PATHS))
    off = ~np.eye(len(x), dtype=bool)
    assert not B[off].any()
    for k in range(len(x)):
        unit = np.broadcast_to(np.eye(len(x))[:, k : k + 1], x.shape)
        change = np.einsum("jjp->jp", first(lambda z: view.diffusion(0.2, z), x, unit) + 0.0 * B)
        assert_small(np.delete(change, k, axis=0), FIRST_ERROR, B)


def has_no_milstein_term(problem: Problem) -> None:
    view = equation(problem)
    x = states(view)
    B = np.broadcast_to(view.diffusion(0.2, x), (len(x), view.noise_dim, PATHS))
    for k in range(view.noise_dim):
        assert_small(first(lambda z: view.diffusion(0.2, z), x, B[:, k]), FIRST_ERROR, B)


def has_normal_milstein_term(problem: Problem) -> None:
    assert problem.has_constraints
    view = problem.view(SDE)
    x = view.admissible(states(problem))
    B = np.broadcast_to(view.diffusion(0.2, x), (len(x), view.noise_dim, PATHS))
    for k in range(view.noise_dim):
        change = first(lambda z: view.diffusion(0.2, z), x, B[:, k])
        for p in range(PATHS):
            gradients = view.dg(x)[..., p]
            rest = change[..., p] - np.linalg.pinv(gradients) @ gradients @ change[..., p]
            assert_small(rest, 4 * FIRST_ERROR, B)


def has_no_constraint(problem: Problem) -> None:
    assert not problem.has_constraints
    assert not problem.residuals({})


def has_a_constraint(problem: Problem) -> None:
    assert problem.has_constraints


def arguments(problem: DelaySDAE) -> tuple[Array, Array, Array]:
    """Return x, v and y with the solution's sizes, one of each on a path."""
    rng, d = np.random.default_rng(8), problem.dimension
    x, v = problem.initial(PATHS).x + rng.standard_normal((2, d, PATHS))
    return x, v, rng.standard_normal((problem.constraints, PATHS))


def has_index_1(problem: Problem) -> None:
    assert isinstance(problem, DelaySDAE)
    assert problem.constraints > 0
    u_y = problem.linearised_constraint(0.2, *arguments(problem)).y
    assert np.linalg.matrix_rank(np.moveaxis(u_y, -1, 0)).min() == problem.constraints


def has_no_delay(problem: Problem) -> None:
    assert not (isinstance(problem, DelaySDAE) and problem.delay)


def has_delayed_noise(problem: Problem) -> None:
    assert isinstance(problem, DelaySDAE)
    x, v, y = arguments(problem)
    values = [problem.diffusion(0.2, z, v, w) for z, w in ((x, y), (y.sum() - 2.0 * x, 1.0 - y))]
    assert np.array_equal(*values)


def is_dissipative(problem: Problem) -> None:
    """Try condition (4.1) at random arguments, far from rounding."""
    assert isinstance(problem, DelaySDAE)
    k = problem.dissipation
    assert k is not None
    assert k.C > 0.0
    (x, v, y), slack = arguments(problem), 1.0 + 64 * EPS
    change = 0.5 * y + 1.0

    def size(z: Array) -> Array:
        return np.sqrt((z * z).sum(axis=tuple(range(z.ndim - 1))))

    f, f_1 = problem.drift(0.0, x, v, y), problem.drift(0.0, 2.0 * v, x, change)
    alone = problem.drift(0.0, x, 0.0 * v, 0.0 * y)
    assert np.all((x * alone).sum(axis=0) <= -k.abar * size(x) ** 2 + 64 * EPS * size(x) ** 2)
    lipschitz = k.al0 * size(x - 2.0 * v) + k.al1 * size(v - x) + k.al2 * size(y - change)
    assert np.all(size(f - f_1) <= slack * lipschitz)
    growth = k.be0 * size(x) ** 2 + k.be1 * size(v) ** 2 + k.be2 * size(y) ** 2
    assert np.all(size(problem.diffusion(0.0, x, v, y)) ** 2 <= slack * growth)


CHECKS: dict[str, Callable[[Problem], None]] = {
    "unconstrained": has_no_constraint,
    "constrained": has_a_constraint,
    "scalar-noise": is_scalar,
    "additive-noise": is_additive,
    "diagonal-noise": is_diagonal,
    "vanishing-milstein-term": has_no_milstein_term,
    "normal-milstein-term": has_normal_milstein_term,
    "algebraic": has_index_1,
    "no-delay": has_no_delay,
    "delayed-noise": has_delayed_noise,
    "dissipative": is_dissipative,
}


def test_declared_traits_are_true(trait: Trait) -> None:
    """The problem's diffusion has the structure that the problem declares."""
    CHECKS[trait.name](trait.spec.build())


def test_every_trait_has_its_check() -> None:
    """No trait can be declared that is not checked here."""
    assert CHECKS.keys() == TRAITS


def two_noises(diffusion: Callable[[float, Array], Array], trait: str) -> SDE:
    on_circle = {"constraint": lambda x: ((x * x).sum(axis=0) - 5.0)[None]}
    circle = on_circle if trait in {"normal-milstein-term", "unconstrained"} else {}
    return SDE(
        drift=lambda t, x: -x,
        diffusion=diffusion,
        start=[1.0, 2.0],
        noise_dim=2,
        horizon=1.0,
        source="planted",
        traits=frozenset({trait}),
        **circle,
    )


FALSE = {
    "unconstrained, but on a circle": (lambda t, x: np.stack([x, x], axis=1), "unconstrained"),
    "constrained, but free": (lambda t, x: np.stack([x, x], axis=1), "constrained"),
    "additive, moves with time": (lambda t, x: (1.0 + t) * np.eye(2)[..., None], "additive-noise"),
    "additive, moves with the state": (lambda t, x: x * np.eye(2)[..., None], "additive-noise"),
    "diagonal, but full": (lambda t, x: np.stack([x, x], axis=1), "diagonal-noise"),
    "diagonal, but crossed": (lambda t, x: x[::-1] * np.eye(2)[..., None], "diagonal-noise"),
    "normal, but faster on one side": (
        lambda t, x: np.stack([x[1] * x[0], -x[0] * x[0]])[:, None] * np.ones((1, 2, 1)),
        "normal-milstein-term",
    ),
    "milstein, but diagonal": (lambda t, x: x * np.eye(2)[..., None], "vanishing-milstein-term"),
}


@pytest.mark.parametrize("name", FALSE)
def test_false_traits_are_noticed(name: str) -> None:
    """A problem that declares a trait it has not cannot be made, or fails the check of this trait."""
    with pytest.raises((AssertionError, ProblemError)):
        CHECKS[FALSE[name][1]](two_noises(*FALSE[name]))


def delayed(**changes: object) -> DelaySDAE:
    """Return dx = -2 x dt + v dW with a delay, and without y, changed."""
    fields = {
        "drift": lambda t, x, v, y: -2.0 * x,
        "diffusion": lambda t, x, v, y: v[:, None],
        "delay": 0.5,
        "history": lambda t: [1.0],
        "noise_dim": 1,
        "horizon": 1.0,
        "source": "planted",
    }
    return DelaySDAE(**{**fields, **changes})


RIGHT = Dissipation(abar=2.0, al0=2.0, al1=0.0, al2=0.0, be0=0.0, be1=1.0, be2=0.0, L1=1.0, L2=0.0, L3=0.0)
FALSE_WITH_DELAY = {
    "noise of the state": ("delayed-noise", {"diffusion": lambda t, x, v, y: x[:, None] + v[:, None]}),
    "no y": ("algebraic", {}),
    "a delay": ("no-delay", {}),
    "less damping": ("dissipative", {"dissipation": RIGHT._replace(abar=2.5)}),
    "more drift": ("dissipative", {"dissipation": RIGHT._replace(al0=1.5)}),
    "more noise": ("dissipative", {"dissipation": RIGHT._replace(be1=0.5)}),
}


@pytest.mark.parametrize("name", FALSE_WITH_DELAY)
def test_false_traits_of_delay_equations_are_noticed(name: str) -> None:
    """The check of a trait passes where the problem has it, and fails where one term is changed."""
    trait, change = FALSE_WITH_DELAY[name]

    with pytest.raises(AssertionError):
        CHECKS[trait](delayed(**change))


def test_true_traits_of_delay_equations_pass() -> None:
    """Delayed noise and the constants of dissipation are recognised, as is the absence of a delay."""
    problem = delayed(dissipation=RIGHT, traits=frozenset({"delayed-noise"}))

    CHECKS["dissipative"](problem)
    CHECKS["delayed-noise"](problem)
    CHECKS["no-delay"](delayed(delay=0.0))
