"""The structure of a chain: derivatives by blocks are those of the whole, and wrong structures are refused."""

from typing import ClassVar

import numpy as np
import pytest

from forms.refusing import refusal
from sdaeverify import HolonomicSDAE, Structure
from sdaeverify.forms.mechanics.structure import Unstructured
from sdaeverify.numerics import BlockBanded

N = 5
STRUCTURE = Structure(nodes=N, owners=(1, 2, 3, 3, 4), width=2, reach=1)


def force(t, r, v):
    """Couple every component of a node with those up to two nodes away."""
    x, y = r.reshape(N, 2, -1), v.reshape(N, 2, -1)
    far = np.zeros_like(x * y)
    far[2:] += np.sin(x[:-2]) * y[2:]
    far[:-1] += x[1:, ::-1] ** 2 - t * y[1:, ::-1]
    return (far + np.cos(x[:, ::-1]) * y - 0.3 * y[:, ::-1] ** 2).reshape(N * 2, -1)


def constraint(r):
    """Fix the lengths between neighbours, and the direction of the fourth edge."""
    d = np.diff(r.reshape(N, 2, -1), axis=0)
    lengths = 0.5 * (1.0 - (d * d).sum(axis=1))
    direction = np.sin(d[2, 1]) - 0.5 * d[2, 0] * d[2, 1]
    return np.stack([*lengths[:3], direction, lengths[3]])


def make(**changes):
    """Return a straight chain of five nodes in the plane, with some of its arguments changed."""
    data = {
        "force": force,
        "diffusion": lambda t, r, v: np.eye(2 * N)[..., None],
        "constraint": constraint,
        "position": np.stack([np.arange(N), np.zeros(N)], axis=1).ravel(),
        "velocity": np.zeros(2 * N),
        "horizon": 1.0,
        "noise_dim": 2 * N,
        "structure": STRUCTURE,
        "source": "made up",
    }
    return HolonomicSDAE(**{**data, **changes})


def matrix(A):
    """Write out a matrix of blocks."""
    K, nodes, a, b, P = A.blocks.shape
    full = np.zeros((nodes, a, nodes, b, P))
    for k in range(K):
        for i in range(nodes):
            if 0 <= i + k - A.lower < nodes:
                full[i, :, i + k - A.lower] = A.blocks[k, i]
    return full.reshape(nodes * a, nodes * b, P)


def blocks(problem, structure, r, v, c):
    """Return all matrices that a structure gives; empty slots of constraints are left out."""
    rows, *sums = structure.curvatures(problem, r, v, np.stack([c, np.roll(c, 1, axis=0)]))
    return [
        *(matrix(part) for part in structure.force_blocks(problem, 0.3, r, v)),
        *(matrix(part)[structure.slots] for part in (structure.constraint_blocks(problem, r), rows)),
        *(matrix(part) for part in sums),
    ]


def state(P=3):
    rng = np.random.default_rng(8)
    return rng.standard_normal((2 * N, P)), rng.standard_normal((2 * N, P)), rng.standard_normal((5, P))


def test_derivatives_of_the_whole_are_the_closed_forms():
    """Of a force with known derivatives and a quadratic constraint."""
    A = np.random.default_rng(1).standard_normal((2, 3, 3))
    problem = make(
        force=lambda t, r, v: np.einsum("ij,jp->ip", A[0], r) + t * np.einsum("ij,jp->ip", A[1], v),
        diffusion=lambda t, r, v: np.eye(3)[..., None],
        constraint=lambda r: 0.5 * (1.0 - (r * r).sum(axis=0))[None],
        position=np.array([1.0, 0.0, 0.0]),
        velocity=np.zeros(3),
        noise_dim=3,
        structure=None,
    )
    r, v, c = np.random.default_rng(2).standard_normal((3, 3, 4))

    by_r, by_v, Dg, rows, total, _ = blocks(problem, problem.blocks, r, v, c[:1])

    assert by_r == pytest.approx(np.repeat(A[0][..., None], 4, axis=-1))
    assert by_v == pytest.approx(np.repeat(0.3 * A[1][..., None], 4, axis=-1))
    assert Dg == pytest.approx(-r[None])
    assert rows == pytest.approx(-v[None], abs=1e-9)
    assert total == pytest.approx(-c[0] * np.eye(3)[..., None], abs=1e-9)


def test_given_derivatives_of_the_force_are_used():
    """What the author gives comes before complex steps, cut into the blocks of the nodes."""
    whole = Unstructured(nodes=1, owners=(0,) * 5)
    plain = make()

    def derivatives(t, r, v):
        by_r, by_v = whole.force_blocks(plain, t, r, v)
        return by_r.blocks[0, 0], by_v.blocks[0, 0]

    given = make(force=lambda t, r, v: force(t, r.real, v.real), force_derivatives=derivatives)
    expected = blocks(plain, STRUCTURE, *state())[:2]

    assert blocks(given, STRUCTURE, *state())[:2] == [pytest.approx(part) for part in expected]
    assert given.why_not_derivative_of_force() == ""


def test_a_force_without_derivative_is_told():
    """A force that is not analytic needs its derivatives from the author."""
    problem = make(force=lambda t, r, v: force(t, r.real, v.real))

    assert "force is not analytic" in problem.why_not_derivative_of_force()
    assert "give force_derivatives" in problem.why_not_derivative_of_force()
    assert make().why_not_derivative_of_force() == ""


def test_a_mass_has_blocks_where_it_couples_no_nodes():
    """The blocks of M^{-1} are the inverses of those of M."""
    block = np.array([[2.0, 0.5], [0.5, 1.0]])
    problem = make(mass=np.kron(np.eye(N), block))

    inverse = problem.blocks.inverse_mass_blocks(problem)

    assert inverse.blocks[0, ..., 0] == pytest.approx(np.repeat(np.linalg.inv(block)[None], N, axis=0))
    assert make().blocks.inverse_mass_blocks(make()) is None


class WrongRows(Structure):
    """Rows v^T Hess g_j with another factor."""

    def curvature_rows(self, problem, r, v):
        return 2.0 * super().curvature_rows(problem, r, v)


class WrongSum(Structure):
    """H(c) without what lies beside the diagonal."""

    def curvature_sum(self, problem, r, c):
        return BlockBanded(super().curvature_sum(problem, r, c).blocks[1:2])


class KnowsForce(Structure):
    """Says that it knows the force's derivatives, and gives zero for them."""

    differentiates_force: ClassVar[bool] = True

    def force_blocks(self, problem, t, r, v):
        zero = BlockBanded(np.zeros((1, N, 2, 2, 1)))
        return zero, zero


def fields(kind, **changes):
    given = {"nodes": N, "owners": STRUCTURE.owners, "width": 2, "reach": 1}
    return {"structure": kind(**{**given, **changes})}


COUPLED = np.eye(2 * N) + 0.1 * np.eye(2 * N, k=2) + 0.1 * np.eye(2 * N, k=-2)
REFUSED = [
    (lambda: fields(Structure, nodes=4, owners=(0, 1, 2, 2, 3)), "structure has 4 nodes and 5 owners"),
    (lambda: fields(Structure, owners=(1, 2, 3, 4)), "structure has 5 nodes and 4 owners"),
    (lambda: fields(Structure, owners=(1, 3, 2, 3, 4)), "owners must be node numbers in non-decreasing order"),
    (lambda: fields(Structure, owners=(1, 2, 3, 3, 5)), "owners must be node numbers in non-decreasing order"),
    (lambda: fields(Structure, width=-1), "width and reach must not be negative"),
    (lambda: fields(Structure, width=1), "derivative of force by its structure disagrees"),
    (lambda: fields(Structure, reach=0), "derivative of constraint by its structure disagrees"),
    (lambda: fields(Structure, owners=(1, 2, 3, 4, 4)), "derivative of constraint by its structure disagrees"),
    (lambda: fields(WrongRows), "curvature_rows disagrees"),
    (lambda: fields(WrongSum), "curvature_sum disagrees"),
    (lambda: fields(KnowsForce), "derivative of force by its structure disagrees"),
    (lambda: {"mass": COUPLED}, "the mass matrix couples nodes"),
    (
        lambda: {"force_derivatives": lambda t, r, v: (np.zeros((2 * N, 2 * N, 1)),) * 2},
        "derivative of force by its structure disagrees",
    ),
    (
        lambda: {"force_derivatives": lambda t, r, v: (np.zeros((2 * N, 1)),) * 2, "structure": None},
        "force_derivatives(t, r, v), by r, returned shape (10, 1)",
    ),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED, ids=lambda x: x if isinstance(x, str) else "")
def test_wrong_structures_are_refused(changes, message):
    """One line says what does not fit."""
    assert message in refusal(lambda: make(**changes()))
