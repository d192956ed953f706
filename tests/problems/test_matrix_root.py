"""Steps of matrices onto a level set of x^T x, against the general search and dense systems, and what is sure."""

import numpy as np
import pytest

from facade import OldNormals
from sdaeverify import Array, Mask
from sdaeverify_problems.matrices import _lyapunov
from sdaeverify_problems.matrices._lyapunov import Lyapunov, dense
from sdaeverify_problems.matrices._root import MatrixLevel
from sdaeverify_problems.matrices.stiefel import stiefel

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


def test_without_root_there_is_no_warning() -> None:
    """Far steps overflow or have no root: a value, and nothing else."""
    problem = stiefel(0.1, 3, 2)
    x = problem.initial(3)
    y = x + np.array([0.1, 30.0, 1e150]) * np.cos(np.arange(6.0))[:, None]

    assert problem.near(x).root(y, np.zeros((3, 3))).converged.tolist() == [True, False, False]


def test_the_equation_is_solved_where_its_series_does_not_converge():
    """Beside paths on which it does: eigenvalues with negative real parts, or far from 1, need the dense matrix."""
    M = np.stack([np.eye(3), np.diag([1.0, -0.5, 2.0]), np.diag([1e-6, 1.0, 1.0]), -np.eye(3) + 0.1], axis=-1)
    b = np.random.default_rng(0).standard_normal((6, 4))
    system = Lyapunov.of(M)

    assert system.poor.tolist() == [False, True, True, True]
    residual = np.einsum("ijp,jp->ip", dense(M), system.solve(b)) - b
    assert np.abs(residual).max() < 1e-9
    assert np.array_equal(system.positive(), np.linalg.det(np.moveaxis(dense(M), -1, 0)) > 0.0)
    assert len(system.powers) == _lyapunov.MOST
