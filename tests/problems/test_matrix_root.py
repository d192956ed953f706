"""Steps of matrices onto a level set of x^T x: against a closed form and the general search, and what is sure."""

import numpy as np
import pytest

from sdaeverify import Increment
from sdaeverify.arrays import Array, Mask
from sdaeverify.numerics import Root
from sdaeverify_problems._matrix_geometry import MatrixGeometry
from sdaeverify_problems._matrix_root import MatrixLevel
from sdaeverify_problems.orthogonal_group import orthogonal_group
from sdaeverify_problems.stiefel import stiefel
from sdaeverify_schemes._multiplier import OldNormals
from sdaeverify_schemes.constrained_euler import ConstrainedEuler

EPS = float(np.finfo(float).eps)
SIZES = [(2, 2), (3, 3), (5, 5), (3, 2), (4, 1), (6, 3)]
PATHS = 200


def around(d: int, p: int, size: float) -> Array:
    """Return random matrices near the frames that consist of the first unit vectors."""
    noise = np.random.default_rng(1).standard_normal((d * p, PATHS))
    return np.eye(d, p).ravel()[:, None] + size * noise


def equation(d: int, p: int, off: float, move: float) -> OldNormals:
    """Return steps of a size from points at a distance from the frames, to levels at half of it."""
    rng, x = np.random.default_rng(2), around(d, p, off)
    problem = stiefel(0.1, d, p)
    level = 0.5 * off * rng.standard_normal((problem.constraints, PATHS))
    return OldNormals(problem.near(x), x + move * rng.standard_normal(x.shape), level)


@pytest.mark.parametrize(("d", "p"), SIZES)
@pytest.mark.parametrize("off", [0.0, 0.05])
def test_the_root_is_that_of_the_general_search(d: int, p: int, off: float) -> None:
    """On the level, along the old normals, and the same point, in fewer iterations."""
    system = equation(d, p, off, 0.08)
    at, y = system.at, system.y

    root, general = at.root(y, system.level), system.search()

    assert root.converged.all()
    assert np.abs(at.problem.constraint(root.x) - system.level).max() < 16 * EPS
    assert np.abs(root.x - y - at.normal(root.x - y)).max() < 16 * EPS
    assert np.abs(root.x - general.x).max() < 64 * EPS
    assert root.iterations.mean() <= general.updates.mean()


@pytest.mark.parametrize("m", [2, 3, 5])
def test_on_the_group_the_step_is_the_closed_one(m: int) -> None:
    """At eps = 0, x+ = x (K + (Id + K^2)^{1/2}) with K the skew part of x^T y."""
    problem, h = orthogonal_group(0.0, m), 0.005
    x = problem.admissible(around(m, m, 0.1))
    dW = np.sqrt(h) * np.random.default_rng(3).standard_normal(x.shape)
    y = x + problem.strength * dW + h * problem.drift(x)

    step = ConstrainedEuler().step(problem, x, 0.0, h, Increment(dW, None))

    assert not step.failed.any()
    matrices, ends = (np.moveaxis(v.reshape(m, m, PATHS), -1, 0) for v in (x, y))
    B = np.swapaxes(matrices, 1, 2) @ ends
    K = 0.5 * (B - np.swapaxes(B, 1, 2))
    squares, vectors = np.linalg.eigh(np.eye(m) + K @ K)
    expected = matrices @ (K + (vectors * np.sqrt(squares)[:, None]) @ np.swapaxes(vectors, 1, 2))
    assert np.abs(step.state.reshape(m, m, PATHS) - np.moveaxis(expected, 0, -1)).max() < 64 * EPS


def positive(x: Array, y: Array) -> Mask:
    """Tell where the symmetric part of x^T y is positive definite."""
    B = np.einsum("niP,njP->Pij", x, y)
    return np.asarray((np.linalg.eigvalsh(B + np.swapaxes(B, 1, 2)) > 0.0).all(axis=1))


@pytest.mark.parametrize(("d", "p"), SIZES)
def test_a_root_is_sure_where_it_is_the_only_one(d: int, p: int) -> None:
    """Long steps: sure roots have positive definite symmetric parts at both ends, and others are not sure."""
    system = equation(d, p, 0.2, 0.5)
    shape = (d, p, PATHS)
    x, y = system.at.x.reshape(shape), system.y.reshape(shape)

    root = system.at.root(system.y, system.level)

    sure = root.converged
    for end in (y, root.x.reshape(shape)):
        assert positive(x[..., sure], end[..., sure]).all()
    assert 0 < np.count_nonzero(sure) < PATHS
    assert np.abs(system.at.problem.constraint(root.x) - system.level)[:, sure].max() < 1e-12
    assert not positive(x, y).all()


@pytest.mark.parametrize("p", [1, 2, 3])
def test_a_far_root_is_never_sure(p: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither that of a y behind the centre, nor that to which a bad guess leads."""
    x, unit = np.eye(3, p)[..., None], np.eye(p)[..., None]

    near, behind = (MatrixLevel.of(x, unit, y, unit).solve() for y in (0.9 * x, -0.9 * x))
    monkeypatch.setattr(MatrixLevel, "_guess", lambda _: -1.8 * unit)
    misled = MatrixLevel.of(x, unit, 0.9 * x, unit).solve()

    for root, value in ((near, 0.1), (behind, 1.9)):
        assert np.allclose(root.x.reshape(p, p, 1), value * unit)
    assert [root.converged.item() for root in (near, behind, misled)] == [True, False, False]


def test_paths_that_are_not_sure_are_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside others that are not: all of them end where the search alone leads."""
    system, whole = equation(3, 3, 0.05, 0.08), MatrixGeometry.root
    doubtful = np.arange(PATHS) % 4 == 0

    def partly(at: MatrixGeometry, y: Array, level: Array) -> Root:
        root = whole(at, y, level)
        return Root(np.where(doubtful, np.nan, root.x), root.converged & ~doubtful, root.iterations)

    monkeypatch.setattr(MatrixGeometry, "root", partly)
    known, reached, alone = system.at.root(system.y, system.level), system.solve(), system.search()

    assert reached.found.all()
    assert np.abs(reached.x - alone.x).max() < 64 * EPS
    assert np.array_equal(reached.x[:, ~doubtful], known.x[:, ~doubtful])
    assert np.array_equal(reached.updates, known.iterations + np.where(doubtful, alone.updates, 0))


def test_without_root_there_is_no_warning() -> None:
    """Far steps overflow or have no root: a value, and nothing else."""
    problem = stiefel(0.1, 3, 2)
    x = problem.initial(3)
    y = x + np.array([0.1, 30.0, 1e150]) * np.cos(np.arange(6.0))[:, None]

    assert problem.near(x).root(y, np.zeros((3, 3))).converged.tolist() == [True, False, False]
