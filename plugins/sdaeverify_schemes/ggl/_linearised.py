"""The derivative of the equations of an implicit Euler step in GGL form, in blocks of nodes.

With A_v = Id - h M^{-1} d_v a, A_r = Id - M^{-1} H(h nu), N = M^{-1} grad g and V the rows v^T Hess g_j, Newton's
equations for the changes of xi, v, h lambda and h nu are

    A_r xi - h v - N h nu = -F_1,   A_v v - M^{-1} { h d_r a + H(h lambda) } xi - N h lambda = -F_2,
    Dg xi = -F_3,                   V xi + Dg v = -F_4.

Substituting v = (A_r xi - N h nu + F_1)/h into the other equations, multiplied by h, and ordering them for a narrow
bandwidth gives

    | -Dg N     h V + Dg A_r                                    0 |  | h nu       |     | h F_4 + Dg F_1  |
    | -A_v N    A_v A_r - h M^{-1} { h d_r a + H(h lambda) }   -N |  | xi         | = - | h F_2 + A_v F_1 |
    | 0         Dg                                              0 |  | h h lambda |     | F_3             |
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.numerics import BlockBanded, apply, largest, solve, solve_blocks

from ._equations import Defects, Equations, Unknowns

# Rounding error of a component relative to its cancelling terms, about the number of terms times eps.
ROUNDINGS = 16.0 * float(np.finfo(float).eps)


Matrix = tuple[tuple[BlockBanded | None, ...], ...]


class Linearised(NamedTuple):
    """Derivative of the equations at a point.

    Attributes
    ----------
    equations : Equations
    A_v, N, Dg, V : BlockBanded
    turning, stiffness : BlockBanded
        Matrices M^{-1} H(h nu) and M^{-1} { h d_r a + H(h lambda) }.
    """

    equations: Equations
    A_v: BlockBanded
    N: BlockBanded
    Dg: BlockBanded
    V: BlockBanded
    turning: BlockBanded
    stiffness: BlockBanded

    def update(self, F: Defects) -> Unknowns:
        """Return Newton's update."""
        blocks, h = self.equations.problem.blocks, self.equations.h
        first, second = blocks.by_node(F.position), blocks.by_node(F.velocity)
        third, fourth = blocks.by_slot(F.constraint), blocks.by_slot(F.hidden)
        right = (h * fourth + self.Dg.times(first), h * second + self.A_v.times(first), third)
        nu, xi, lam = (solve_node if blocks.nodes == 1 else solve_blocks)(self._matrix(), [-part for part in right])
        v = (xi - self.turning.times(xi) - self.N.times(nu) + first) / h
        n = F.position.shape
        return Unknowns(xi.reshape(n), v.reshape(n), blocks.by_constraint(lam) / h, blocks.by_constraint(nu))

    def rounding(self, x: Unknowns, F: Defects) -> Iterator[Array]:
        """Yield the rounding error of each equation, those of the constraint first; shape (P,).

        A position has the rounding error eps |r|, which stiff forces and sharp constraints magnify: the bending of a
        chain gives h 16 alpha^{-2} ds^{-4} eps |r| in the velocity's equation.
        """
        r, v, size = largest(self.equations.r + x.xi), largest(x.v), self.Dg.size()
        yield ROUNDINGS * (size * r)
        yield ROUNDINGS * (self.V.size() * r + size * v)
        terms = largest(x.xi) + largest(F.shift)
        yield ROUNDINGS * (terms + self.turning.size() * r + self.equations.h * v)
        terms = largest(self.equations.v) + (largest(F.moving) + largest(F.pulling) + largest(F.kicking))
        yield ROUNDINGS * (terms + self.stiffness.size() * r + self.A_v.size() * v)

    def _matrix(self) -> Matrix:
        blocks, h, minus = self.equations.problem.blocks, self.equations.h, -1.0 * self.N
        one, unused = BlockBanded.identity(blocks.nodes, len(self.equations.r) // blocks.nodes), blocks.empty_slots
        A_r = one - self.turning
        # Signs are applied to the smallest factors. The unknown of a slot without constraint is 0.
        return (
            (unused + self.Dg @ minus, h * self.V + self.Dg @ A_r, None),
            (self.A_v @ minus, self.A_v @ A_r + (-h) * self.stiffness, minus),
            (None, self.Dg, unused),
        )


def solve_node(rows: Matrix, right: Sequence[Array]) -> list[Array]:
    """Solve the equations of a single node: the middle block for xi, then a Schur complement for the others.

        | D  C  0 |  | x |   | a |
        | A  K  E |  | y | = | b |     y = K^{-1} b - K^{-1} ( A E ) (x, z)
        | 0  B  0 |  | z |   | c |

    Parameters
    ----------
    rows : tuple of tuples of BlockBanded or None
    right : sequence of ndarrays, shape (1, ., P)
        Right-hand sides a, b and c.

    Returns
    -------
    list of ndarray, shape (1, ., P)
        Solutions x, y and z.
    """
    (D, C, _), (A, K, E), (_, B, _) = ([None if part is None else part.blocks[0, 0] for part in row] for row in rows)
    (a, b, c), (m, n, _) = (part[0] for part in right), B.shape
    acting, constraints = np.empty((n, 2 * m + 1, b.shape[-1])), np.empty((2 * m, n, b.shape[-1]))
    acting[:, :m], acting[:, m:-1], acting[:, -1] = A, E, b
    constraints[:m], constraints[m:] = C, B
    moved = solve(K, acting)
    system = apply(constraints, moved)
    system[:m, :m] -= D
    system[:m, -1] -= a
    system[m:, -1] -= c
    xz = solve(system[:, :-1], system[:, -1])
    y = moved[:, -1] - apply(moved[:, :-1], xz)
    return [xz[None, :m], y[None], xz[None, m:]]


def linearise(equations: Equations, x: Unknowns) -> Linearised:
    """Return the derivative of the equations at a point."""
    problem, h, r = equations.problem, equations.h, equations.r + x.xi
    blocks = problem.blocks
    W = blocks.inverse_mass_blocks(problem)
    a_r, a_v = blocks.force_blocks(problem, equations.t, r, x.v)
    Dg = blocks.constraint_blocks(problem, r)
    V, pulling, turning = blocks.curvatures(problem, r, x.v, np.array((x.lam, x.nu)))
    stiffness, N = h * a_r + pulling, Dg.transposed()
    if W is not None:
        a_v, stiffness, turning, N = (W @ part for part in (a_v, stiffness, turning, N))
    A_v = BlockBanded.identity(blocks.nodes, len(r) // blocks.nodes) + (-h) * a_v
    return Linearised(equations, A_v, N, Dg, V, turning, stiffness)
