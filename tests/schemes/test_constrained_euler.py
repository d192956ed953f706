"""Euler steps of constrained Langevin dynamics: its equations, its roots, and what it does without one."""

import numpy as np
import pytest
from scipy.optimize import root

from schemes.rough_constraints import SIGMA, D, drift, langevin, points, rough
from sdaeverify import ConstrainedLangevin, Increment, ParameterError
from sdaeverify.arrays import Array
from sdaeverify.measures.strong.findings import judge_strong
from sdaeverify.numerics import norm
from sdaeverify.probe.local.strong_defects import local_strong
from sdaeverify.probe.local.strong_order import strong_order
from sdaeverify_problems._affine_langevin import AffineLangevin
from sdaeverify_problems.affine_constraint import affine_constraint, affine_langevin
from sdaeverify_schemes._multiplier import OldNormals
from sdaeverify_schemes.constrained_euler import ConstrainedEuler

EPS = float(np.finfo(float).eps)
H = 0.02
THETA = {"old": 0.0, "new": 1.0}


def increments(x: Array, h: float = H) -> Increment:
    return Increment(np.sqrt(h) * np.random.default_rng(3).standard_normal(x.shape), None)


@pytest.mark.parametrize("direction", ["old", "new"])
@pytest.mark.parametrize("q", [1, 2, 3])
def test_a_step_solves_the_printed_equations(q: int, direction: str) -> None:
    """The new point is the solution of (1.6) or (2.7) by a solver of all equations at once."""
    x, problem = points(q, 0.0), langevin(q, 0.0)
    noise = increments(x)

    result = ConstrainedEuler(direction=direction).step(problem, x, 0.0, H, noise)

    assert not result.failed.any()
    for p in range(x.shape[1]):
        y = x[:, p] + SIGMA * noise.dW[:, p] + H * drift(x[:, p])

        def defects(z: Array, old: Array = x[:, p], y: Array = y) -> Array:
            normals = rough(q).gradient(z[:D] if direction == "new" else old)
            return np.concatenate([z[:D] - y - normals @ z[D:], rough(q).zeta(z[:D])])

        expected = root(defects, np.concatenate([y, np.zeros(q)]), tol=1e-13).x[:D]
        assert np.abs(result.state[:, p] - expected).max() < 1e-11


@pytest.mark.parametrize("solver", ["newton", "frozen"])
@pytest.mark.parametrize("q", [1, 2, 3])
def test_the_constraint_holds_to_rounding(q: int, solver: str) -> None:
    """After 50 steps zeta is a rounding error of one step."""
    problem, scheme = langevin(q, 0.0), ConstrainedEuler(solver=solver)
    x = problem.initial(40)
    for n in range(50):
        dW = 0.05 * np.random.default_rng(n).standard_normal(x.shape)
        x = scheme.step(problem, x, 0.0, 0.005, Increment(dW, None)).state

    ((value, scale),) = problem.residuals({"x": x}).values()
    assert np.abs(x).max() > 0.1
    assert np.all(np.abs(value) <= 16 * EPS * np.maximum(1.0, scale))


@pytest.mark.parametrize("direction", ["old", "new"])
@pytest.mark.parametrize("q", [1, 2, 3])
def test_a_step_on_a_flat_is_the_closed_recursion(q: int, direction: str) -> None:
    """A step is Pi (Id - h K) x + ... to rounding in both directions; eps > 0 is ignored."""
    affine: AffineLangevin = affine_langevin(0.0, 5, q, 0.5, 0.7)
    M, r, N = affine.constrained_euler(H)
    for eps in (0.0, 0.1):
        problem = affine_constraint(eps, d=5, q=q)
        x = problem.initial(20)
        noise = increments(x)
        new = ConstrainedEuler(direction=direction).step(problem, x, 0.0, H, noise).state
        assert np.abs(new - (M @ x + r[:, None] + N @ noise.dW / np.sqrt(H))).max() < 16 * EPS * np.abs(x).max()


def sphere(d: int = 3) -> ConstrainedLangevin:
    return ConstrainedLangevin(
        drift=lambda x: 0.0 * x,
        strength=1.0,
        eps=0.0,
        constraint=lambda x: 0.5 * ((x * x).sum(axis=0) - 1.0)[None],
        start=np.eye(d)[0],
        hessians=np.eye(d)[None],
        horizon=1.0,
        source="made up",
    )


def kicked(h: float) -> tuple[Array, Increment]:
    rng = np.random.default_rng(7)
    x = rng.standard_normal((3, 2000))
    x = x / norm(x)
    return x, Increment(np.sqrt(h) * rng.standard_normal(x.shape), None)


@pytest.mark.parametrize("h", [0.05, 0.5, 2.0])
def test_the_root_on_the_sphere_is_the_near_one(h: float) -> None:
    """Along the old normal the new point is tangential plus sqrt(1 - |tangential|^2) x, as long as there is one.

    Where y lies behind the centre, the root that lambda = 0 leads to is the far one: none is admissible.
    """
    x, noise = kicked(h)
    y = x + noise.dW
    along = (y * x).sum(axis=0)
    tangential = y - along * x
    room = 1.0 - norm(tangential) ** 2
    solvable, apart = (room > 0.0) & (along > 0.0), (np.abs(room) > 1e-3) & (np.abs(along) > 1e-3)

    result = ConstrainedEuler().step(sphere(), x, 0.0, h, noise)

    expected = tangential + np.sqrt(np.where(solvable, room, 0.0)) * x
    assert np.array_equal(result.failed[apart], ~solvable[apart])
    assert (~solvable).any() == (h > 0.1)
    # The root is badly conditioned where the two meet: rounding of |y|^2 over its root. And each component of the
    # first update, of length |zeta(y)/<x, y>|, is rounded, across x too, where no later update goes.
    first = 0.5 * np.abs(1.0 - norm(y) ** 2) / np.abs(along)
    error = 16 * EPS * (1.0 + norm(y) ** 2) / np.sqrt(np.abs(room)) + EPS * first
    known = apart & solvable
    assert np.all(norm(result.state - expected)[known] <= error[known])


@pytest.mark.parametrize("h", [0.05, 0.5])
def test_along_the_new_normal_a_step_on_the_sphere_is_radial(h: float) -> None:
    """Along the new normal the new point is y/|y|, which is near enough where |y| > 1/2."""
    x, noise = kicked(h)
    y = x + noise.dW
    expected, length = y / norm(y), norm(y)

    result = ConstrainedEuler(direction="new").step(sphere(), x, 0.0, h, noise)

    found = ~result.failed
    assert found[length > 0.75].all()
    # Rounding of y over the distance to the centre.
    assert np.all(norm(result.state - expected)[found] <= 32 * EPS / length[found])


@pytest.mark.parametrize("no_root", ["hold", "fail"])
def test_paths_without_root_are_reported(no_root: str) -> None:
    """They keep their state or become NaN, as the parameter says, and their neighbours go where they go alone."""
    x, noise = kicked(0.5)

    result = ConstrainedEuler(no_root=no_root).step(sphere(), x, 0.0, 0.5, noise)

    kept = x if no_root == "hold" else np.full_like(x, np.nan)
    assert 0 < np.count_nonzero(result.failed) < 1000
    assert np.array_equal(result.state[:, result.failed], kept[:, result.failed], equal_nan=True)
    tame = Increment(np.where(result.failed, 0.0, noise.dW), None)
    alone = ConstrainedEuler().step(sphere(), x, 0.0, 0.5, tame).state
    assert np.array_equal(result.state[:, ~result.failed], alone[:, ~result.failed])


def followed(equation: OldNormals) -> tuple[Array, Array]:
    """Follow the root from lambda = 0 while the level moves from zeta(y), and tell where det > 0 all along."""
    at, z, steps = equation.at, equation.y, 200
    begin, connected = at.problem.constraint(z), np.ones(z.shape[1], dtype=bool)
    for part in np.arange(1, steps + 1) / steps:
        level = begin + part * (equation.level - begin)
        for _ in range(6):
            new = at.problem.near(z)
            update = at.J.transposed(new.J.gram(at.J).solve(new.zeta - level))
            z = np.where(connected, z - update, z)
        connected &= at.problem.near(z).J.gram(at.J).positive() & (norm(update) < 1e-9)
    return z, connected


@pytest.mark.parametrize("q", [1, 2, 3])
def test_the_root_is_connected_to_the_small_multipliers(q: int) -> None:
    """On long steps, the accepted root is the one that a continuation in the level leads to."""
    problem, h, count = langevin(q, 0.0), 0.08, 2000
    x = points(q, 0.0, count=count)
    y = x + SIGMA * increments(x, h).dW
    equation = OldNormals(problem.near(x), y, np.zeros((q, count)))

    with np.errstate(all="ignore"):
        reached = equation.solve()
        expected, connected = followed(equation)

    same = norm(reached.x - expected) < 1e-6
    assert connected.all() == (q < 3)
    assert not (reached.found & ~(connected & same)).any()
    assert np.mean(connected & ~reached.found) <= 1e-3


@pytest.mark.parametrize("direction", ["old", "new"])
def test_the_strong_order_is_one_half(direction: str) -> None:
    """One step and two half steps differ by the Milstein term, of size h and mean 0: not order 1, but 1/2."""
    record = local_strong(ConstrainedEuler(direction=direction), sphere())
    orders = strong_order(record, None)

    assert judge_strong(orders, 0.5 - 0.2).verdict == "verified"
    assert judge_strong(orders, 1.0 - 0.2).verdict == "refuted"


def test_parameters_that_make_no_sense_are_refused() -> None:
    """The direction and the solver are named."""
    with pytest.raises(ParameterError, match="direction must be old or new, got 'mean'"):
        ConstrainedEuler(direction="mean")
    with pytest.raises(ParameterError, match="needs the normals at the old point"):
        ConstrainedEuler(direction="new", solver="frozen")
