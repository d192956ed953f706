"""Euler steps of constrained Langevin dynamics: its equations, its roots, and what it does without one."""

import numpy as np
import pytest
from scipy.optimize import root

from facade import ConstrainedEuler, EulerMaruyama, OldNormals, PenalisedEuler
from schemes.rough_constraints import SIGMA, D, drift, langevin, points, rough
from sdaeverify import SDE, Array, ConstrainedLangevin, Increment
from sdaeverify.numerics import norm

EPS = float(np.finfo(float).eps)
H = 0.02


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


@pytest.mark.sweep
@pytest.mark.parametrize("q", [1, 2, 3])
def test_the_root_is_connected_to_the_small_multipliers(q: int) -> None:
    """On long steps, the accepted root is the one that a continuation in the level leads to."""
    problem, h, count = langevin(q, 0.0), 0.08, 500
    x = points(q, 0.0, count=2000)
    x, y = (each[:, :count] for each in (x, x + SIGMA * increments(x, h).dW))
    equation = OldNormals(problem.near(x), y, np.zeros((q, count)))

    with np.errstate(all="ignore"):
        reached = equation.solve()
        expected, connected = followed(equation)

    same = norm(reached.x - expected) < 1e-6
    assert connected.all() == (q < 3)
    assert not (reached.found & ~(connected & same)).any()
    assert np.mean(connected & ~reached.found) <= 1e-3


@pytest.mark.parametrize("q", [1, 2, 3])
def test_the_penalised_step_is_that_of_euler_maruyama(q: int) -> None:
    """It is Euler-Maruyama for (1.4), which the form offers to schemes for SDEs; the limit has no such step."""
    problem, x = langevin(q, 0.1), points(q, 0.2)

    result = PenalisedEuler().step(problem, x, 0.0, H, increments(x)).state

    expected = EulerMaruyama().step(problem.view(SDE), x, 0.0, H, increments(x)).state
    assert np.abs(result - expected).max() < 16 * EPS
    assert "eps = 0" in PenalisedEuler().refuses(langevin(q, 0.0))
    assert not PenalisedEuler().refuses(langevin(q, 1e-6))
