"""The derivative of the equations of an implicit Euler step in GGL form, in blocks of nodes.

With A_v = Id - h M^{-1} d_v a, A_r = Id - M^{-1} H(h nu), N = M^{-1} grad g and V the rows v^T Hess g_j, Newton's
equations for the changes of xi, v, h lambda and h nu are

    A_r xi - h v - N h nu = -F_1,   A_v v - M^{-1} { h d_r a + H(h lambda) } xi - N h lambda = -F_2,
    Dg xi = -F_3,                   V xi + Dg v = -F_4.

v = (A_r xi - N h nu + F_1)/h is put into the others, which are multiplied by h; in the order that keeps the band of
entries narrow they read

    | -Dg N     h V + Dg A_r                                    0 |  | h nu       |     | h F_4 + Dg F_1  |
    | -A_v N    A_v A_r - h M^{-1} { h d_r a + H(h lambda) }   -N |  | xi         | = - | h F_2 + A_v F_1 |
    | 0         Dg                                              0 |  | h h lambda |     | F_3             |
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify.numerics import BlockBanded, identity, largest, solve_blocks

from ._ggl_equations import Defects, Equations, Unknowns, rows

# Rounding errors of a component, in units of eps times the terms that cancel in it: about as many as there are terms.
ROUNDINGS = 16.0 * float(np.finfo(float).eps)


class Linearised(NamedTuple):
    """The derivative at a point.

    Attributes
    ----------
    equations : Equations
    matrix : tuple of tuples of BlockBanded or None
    A_v, N, Dg : BlockBanded
    turning : BlockBanded
        M^{-1} H(h nu).
    by_r, by_v : ndarray, shape (4, P)
        How much errors of r and of v change each equation, in the norm of largest components.
    """

    equations: Equations
    matrix: tuple[tuple[BlockBanded | None, ...], ...]
    A_v: BlockBanded
    N: BlockBanded
    Dg: BlockBanded
    turning: BlockBanded
    by_r: Array
    by_v: Array

    def update(self, F: Defects) -> Unknowns:
        """Return Newton's update."""
        blocks, h = self.equations.problem.blocks, self.equations.h
        first, second = blocks.by_node(F.position), blocks.by_node(F.velocity)
        third, fourth = blocks.by_slot(F.constraint), blocks.by_slot(F.hidden)
        right = (h * fourth + self.Dg.times(first), h * second + self.A_v.times(first), third)
        nu, xi, lam = solve_blocks(self.matrix, [-part for part in right])
        v = (xi - self.turning.times(xi) - self.N.times(nu) + first) / h
        n = F.position.shape
        return Unknowns(xi.reshape(n), v.reshape(n), blocks.by_constraint(lam) / h, blocks.by_constraint(nu))

    def rounding(self, x: Unknowns, F: Defects) -> Array:
        """Return what rounding may leave of each equation, shape (4, P).

        A position is known up to eps |r|, which stiff forces and sharp constraints magnify: the bending of a chain
        leaves h 16 alpha^{-2} ds^{-4} eps |r| of the velocity's equation.
        """
        return ROUNDINGS * (F.terms + self.by_r * largest(self.equations.r + x.xi) + self.by_v * largest(x.v))


def linearise(equations: Equations, x: Unknowns) -> Linearised:
    """Return the derivative of the equations at a point."""
    problem, h, r = equations.problem, equations.h, equations.r + x.xi
    blocks = problem.blocks
    W = blocks.inverse_mass_blocks(problem)
    a_r, a_v = blocks.force_blocks(problem, equations.t, r, x.v)
    Dg = blocks.constraint_blocks(problem, r)
    V, pulling, turning = blocks.curvatures(problem, r, x.v, np.stack([x.lam, x.nu]))
    stiffness, N = h * a_r + pulling, Dg.transposed()
    if W is not None:
        a_v, stiffness, turning, N = (W @ part for part in (a_v, stiffness, turning, N))
    unit, unused = identity(blocks.nodes, len(r) // blocks.nodes), blocks.empty_slots
    # Signs go where there is least to be multiplied by them.
    A_v, A_r, minus = unit + (-h) * a_v, unit - turning, -1.0 * N
    # The unknown of a slot that no constraint has is 0.
    matrix = (
        (unused + Dg @ minus, h * V + Dg @ A_r, None),
        (A_v @ minus, A_v @ A_r + (-h) * stiffness, minus),
        (None, Dg, unused),
    )
    size, none = Dg.size(), np.zeros(r.shape[-1])
    by_r = rows(none + turning.size(), stiffness.size(), size, V.size())
    by_v = rows(none + h, A_v.size(), 0.0, size)
    return Linearised(equations, matrix, A_v, N, Dg, turning, by_r, by_v)
