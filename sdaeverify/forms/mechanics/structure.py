"""Coupling structure of constrained problems: a row of nodes, of which only neighbours are coupled."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import ClassVar

import numpy as np

from ...arrays import Array
from ...errors import ProblemError
from ...numerics.block_banded import BlockBanded, overlap
from ...numerics.derivatives import directional
from ..checks import PROBES, check_derivative, check_shape, wave
from .multiplied import Mechanics


@dataclass(frozen=True)
class Structure:
    """A row of nodes with d positions each: rows i d to i d + d - 1 of r and of v are those of node i = 0, 1, ...

    It provides the derivatives that implicit schemes need, in blocks of nodes. They are taken along sums of unit
    vectors of several nodes, at most one of which affects any row, so that the number of derivatives is independent
    of the number of nodes. A subclass may have them in closed form; it sets `differentiates_force` if it has those of
    the force. Each node has q slots for its constraints; the slots of a node with fewer constraints stay zero.

    Attributes
    ----------
    nodes : int
        Number N of nodes.
    owners : tuple of int, length m
        For each constraint, in their order, the last node that it touches; these must not decrease.
    width : int
        Maximum distance between a node and those that the force on it depends on.
    reach : int
        Number of nodes before its owner that a constraint touches.

    Raises
    ------
    ProblemError
        If the numbers are inconsistent.
    """

    differentiates_force: ClassVar[bool] = False

    nodes: int
    owners: tuple[int, ...]
    width: int = 0
    reach: int = 0

    def __post_init__(self) -> None:
        ordered = self.owners == tuple(sorted(self.owners)) and {*self.owners} <= set(range(self.nodes))
        if self.nodes < 1 or not self.owners or not ordered or min(self.width, self.reach) < 0:
            expected = "owners must be nodes that do not decrease, width and reach not negative"
            raise ProblemError(f"structure: {expected}, got {self}")

    @cached_property
    def slots(self) -> Array:
        """Index of each constraint among the N q slots of all nodes, shape (m,)."""
        owners = np.array(self.owners)
        return owners * self.slots_per_node + np.arange(len(owners)) - np.searchsorted(owners, owners)

    @property
    def slots_per_node(self) -> int:
        """Largest number q of constraints of a node."""
        return int(np.bincount(self.owners).max())

    def by_slot(self, c: Array) -> Array:
        """Return constraint data ordered by nodes, shape (m, ...) -> (N, q, ...); empty slots are zero."""
        spread = np.zeros((self.nodes * self.slots_per_node, *c.shape[1:]), dtype=c.dtype)
        spread[self.slots] = c
        return spread.reshape(self.nodes, self.slots_per_node, *c.shape[1:])

    def by_constraint(self, c: Array) -> Array:
        """Return slot data ordered by constraints, shape (N, q, P) -> (m, P)."""
        return np.asarray(c.reshape(-1, c.shape[-1])[self.slots])

    def by_node(self, y: Array) -> Array:
        """Return position data ordered by nodes, shape (n, P) -> (N, d, P)."""
        return y.reshape(self.nodes, -1, y.shape[-1])

    def inverse_mass_blocks(self, problem: Mechanics) -> BlockBanded | None:
        """Return M^{-1}, blocks of shape (d, d, 1), or None for the identity; the mass must not couple nodes."""
        if problem.mass is None:
            return None
        return self._cut_blocks(problem.inverse_mass(np.eye(problem.dimension))[..., None], 0)

    def force_blocks(self, problem: Mechanics, t: float, r: Array, v: Array) -> tuple[BlockBanded, BlockBanded]:
        """Return the derivatives of a(t, r, v) by r and by v, blocks of shape (d, d, P) or (d, d, 1).

        Parameters
        ----------
        problem : Mechanics
        t : float
        r, v : ndarray, shape (n, P)
            Where the derivatives are evaluated.
        """
        if problem.force_derivatives is not None:
            by_r, by_v = problem.force_derivatives(t, r, v)
            return self._cut_blocks(by_r, self.width), self._cut_blocks(by_v, self.width)
        return (
            self._differentiate(lambda x: problem.force(t, x, v), r),
            self._differentiate(lambda x: problem.force(t, r, x), v),
        )

    def constraint_blocks(self, problem: Mechanics, r: Array) -> BlockBanded:
        """Return Dg(r), blocks of shape (q, d, P), with `reach` diagonals below the main one and none above."""
        J = problem.linearised(r)
        return self._rows(r, J.times)

    def curvature_rows(self, problem: Mechanics, r: Array, v: Array) -> BlockBanded:
        """Return the rows v^T Hess g_j(r), blocks of shape (q, d, P), diagonals like those of Dg.

        Parameters
        ----------
        problem : Mechanics
        r : ndarray, shape (n, P)
            Where the second derivatives are evaluated.
        v : ndarray, shape (n, P)
            Direction.
        """
        return self._rows(r, lambda y: problem.d2g(r, v, y))

    def curvature_sum(self, problem: Mechanics, r: Array, c: Array) -> BlockBanded:
        """Return H(c) = sum_j c_j Hess g_j(r), c of shape (m, P): blocks of shape (d, d, P).

        Parameters
        ----------
        problem : Mechanics
        r : ndarray, shape (n, P)
            Where the second derivatives are evaluated.
        c : ndarray, shape (m, P)
            Weights of the constraints, such as multipliers.
        """
        d = len(r) // self.nodes
        blocks = np.zeros((2 * self.reach + 1, self.nodes, d, d, r.shape[-1]))

        def weigh(y: Array, z: Array) -> Array:
            return c * problem.d2g(r, y, z)

        for nodes, component, y in self._units(r, self.reach + 1):
            rows = self._rows(r, partial(weigh, y))
            for before in range(self.reach + 1):
                owners = self._within(nodes + before)
                for k in range(self.reach + 1):
                    blocks[k + before, owners - before, component] += rows.blocks[k, owners].sum(axis=1)
        return BlockBanded(blocks, self.reach)

    def curvatures(self, problem: Mechanics, r: Array, v: Array, c: Array) -> tuple[BlockBanded, ...]:
        """Return the rows v^T Hess g_j(r), and H(c_k) for every c_k of c; see `curvature_rows` and `curvature_sum`.

        Parameters
        ----------
        problem : Mechanics
        r, v : ndarray, shape (n, P)
            Where the second derivatives are evaluated, and the direction.
        c : ndarray, shape (k, m, P)
            Weights of the constraints.
        """
        sums = (self.curvature_sum(problem, r, each) for each in c)
        return self.curvature_rows(problem, r, v), *sums

    @property
    def empty_slots(self) -> BlockBanded:
        """Identity on the slots without a constraint, blocks of shape (q, q, 1)."""
        used = self.by_slot(np.ones(len(self.owners)))
        return BlockBanded((np.eye(self.slots_per_node) * (1.0 - used)[:, None])[None, ..., None])

    def _within(self, nodes: Array) -> Array:
        return nodes[(nodes >= 0) & (nodes < self.nodes)]

    def _units(self, x: Array, period: int) -> Iterator[tuple[Array, int, Array]]:
        # Nodes that are a period apart, a component, and the sum of the unit vectors of this component of these
        # nodes.
        d = len(x) // self.nodes
        for first in range(min(period, self.nodes)):
            for component in range(d):
                y = np.zeros((self.nodes, d, 1))
                y[first::period, component] = 1.0
                yield np.arange(first, self.nodes, period), component, np.broadcast_to(y.reshape(-1, 1), x.shape)

    def _differentiate(self, f: Callable[[Array], Array], x: Array) -> BlockBanded:
        # Df(x), by complex steps.
        d, w = len(x) // self.nodes, self.width
        blocks = np.zeros((2 * w + 1, self.nodes, d, d, x.shape[-1]))
        for nodes, component, y in self._units(x, 2 * w + 1):
            value = self.by_node(np.broadcast_to(directional(f, x, y), x.shape))
            for k in range(2 * w + 1):
                rows = self._within(nodes + w - k)
                blocks[k, rows, :, component] = value[rows]
        return BlockBanded(blocks, w)

    def _rows(self, r: Array, f: Callable[[Array], Array]) -> BlockBanded:
        # The matrix of a linear f : (n, P) -> (m, P) with the sparsity of the constraints.
        q, d = self.slots_per_node, len(r) // self.nodes
        blocks = np.zeros((self.reach + 1, self.nodes, q, d, r.shape[-1]))
        for nodes, component, y in self._units(r, self.reach + 1):
            value = self.by_slot(f(y))
            for k in range(self.reach + 1):
                rows = self._within(nodes + self.reach - k)
                blocks[k, rows, :, component] = value[rows]
        return BlockBanded(blocks, self.reach)

    def _cut_blocks(self, matrix: Array, width: int) -> BlockBanded:
        # The blocks near the diagonal of a matrix of shape (n, n, P).
        N, d = self.nodes, len(matrix) // self.nodes
        parts = matrix.reshape(N, d, N, d, -1)
        blocks, nodes = np.zeros((2 * width + 1, N, d, d, matrix.shape[-1])), np.arange(N)
        for k in range(2 * width + 1):
            rows, columns = overlap(N, k - width)
            blocks[k, rows] = parts[nodes[rows], :, nodes[columns]]
        return BlockBanded(blocks, width)


class Unstructured(Structure):
    """One node; derivatives along all unit vectors are taken at once, as if they were further paths."""

    def by_slot(self, c: Array) -> Array:
        """Return constraint data ordered by nodes, shape (m, ...) -> (1, m, ...)."""
        return c[None]

    def by_constraint(self, c: Array) -> Array:
        """Return slot data ordered by constraints, shape (1, m, P) -> (m, P)."""
        return np.asarray(c[0])

    def force_blocks(self, problem: Mechanics, t: float, r: Array, v: Array) -> tuple[BlockBanded, BlockBanded]:
        """Return the derivatives of a(t, r, v) by r and by v, blocks of shape (n, n, P) or (n, n, 1)."""
        if problem.force_derivatives is not None:
            return super().force_blocks(problem, t, r, v)
        n, P = r.shape
        sides = n * P
        x, unit = repeat_paths(np.concatenate([r, v]), 2 * n), units(2 * n, P)
        change = directional(lambda z: problem.force(t, z[:n], z[n:]), x, unit)
        by_x = np.broadcast_to(change, (n, 2 * sides)).reshape(n, 2, n, P)
        return one_block(by_x[:, 0]), one_block(by_x[:, 1])

    def constraint_blocks(self, problem: Mechanics, r: Array) -> BlockBanded:
        """Return Dg(r), one block of shape (m, n, P)."""
        return one_block(problem.dg(r))

    def curvatures(self, problem: Mechanics, r: Array, v: Array, c: Array) -> tuple[BlockBanded, ...]:
        """Return v^T Hess g_j(r), one block of shape (m, n, P), and every H(c_k), of shape (n, n, P)."""
        n, P = r.shape
        second = problem.d2g(repeat_paths(r, n * n), units(n, n * P), repeat_paths(units(n, P), n))
        hessian = np.broadcast_to(second, (len(second), n * n * P)).reshape(-1, n, n, P)
        sums = np.einsum("kmp,mijp->kijp", c, hessian)
        return one_block(np.einsum("mijp,ip->mjp", hessian, v)), *map(one_block, sums)


def repeat_paths(x: Array, times: int) -> Array:
    """Repeat all paths, shape (n, P) -> (n, times P)."""
    return np.concatenate([x] * times, axis=1)


def units(n: int, paths: int) -> Array:
    """Return the unit vectors of n components, each for all paths, shape (n, n P)."""
    return np.repeat(np.eye(n), paths, axis=1)


def one_block(matrix: Array) -> BlockBanded:
    """Return a matrix of shape (a, b, P) as one block."""
    return BlockBanded(matrix[None, None])


def check_structure(structure: Structure, problem: Mechanics, r: Array, v: Array) -> None:
    """Check that a problem couples no more nodes than its structure says, and that its derivatives are correct.

    Parameters
    ----------
    structure : Structure
        The coupling that the problem declares.
    problem : Mechanics
    r, v : ndarray, shape (n, P)
        Where derivatives are compared with differences.

    Raises
    ------
    ProblemError
        If the numbers of nodes and owners do not fit, if the mass couples nodes, or if a derivative disagrees.
    """
    n = problem.dimension
    if n % structure.nodes or len(structure.owners) != problem.constraints:
        given = f"{structure.nodes} nodes and {len(structure.owners)} owners"
        raise ProblemError(f"structure has {given}, the problem {n} positions and {problem.constraints} constraints")
    if problem.mass is not None and structure.nodes > 1:
        _check_mass(structure, problem)
    if problem.force_derivatives is not None:
        for name, value in zip(("r", "v"), problem.force_derivatives(0.0, r, v), strict=True):
            check_shape(f"force_derivatives(t, r, v), by {name},", value, (n, n, PROBES))
    if isinstance(structure, Unstructured) and problem.force_derivatives is None:
        return
    if not problem.why_not_derivative_of_force():
        _check_force(structure, problem, np.concatenate([r, v]))
    _check_constraint(structure, problem, r)


def _check_mass(structure: Structure, problem: Mechanics) -> None:
    y = wave((problem.dimension, PROBES))
    blocks = structure.inverse_mass_blocks(problem)
    assert blocks is not None
    if not np.allclose(blocks.times(structure.by_node(y)).reshape(y.shape), problem.inverse_mass(y), rtol=1e-12):
        raise ProblemError("structure: the mass couples nodes, which it must not; leave structure out")


def _check_force(structure: Structure, problem: Mechanics, x: Array) -> None:
    n, t = problem.dimension, 0.5 * problem.horizon

    def force(z: Array) -> Array:
        return np.broadcast_to(problem.force(t, z[:n], z[n:]), z[:n].shape)

    def derivative(z: Array, y: Array) -> Array:
        by_r, by_v = structure.force_blocks(problem, t, z[:n], z[n:])
        change = by_r.times(structure.by_node(y[:n])) + by_v.times(structure.by_node(y[n:]))
        return np.broadcast_to(change.reshape(n, -1), z[:n].shape)

    check_derivative("the derivative of force by its structure", force, derivative, x)


def _check_constraint(structure: Structure, problem: Mechanics, r: Array) -> None:
    def derivative(x: Array, y: Array) -> Array:
        return structure.by_constraint(structure.constraint_blocks(problem, x).times(structure.by_node(y)))

    check_derivative("the derivative of constraint by its structure", problem.constraint, derivative, r)
    x, y, c = r + 0.1 * wave(r.shape), wave(r.shape)[::-1].copy(), wave((problem.constraints, PROBES))
    z = np.roll(y, 1, axis=0)
    rows = structure.by_constraint(structure.curvature_rows(problem, x, y).times(structure.by_node(z)))
    total = (y * structure.curvature_sum(problem, x, c).times(structure.by_node(z)).reshape(y.shape)).sum(axis=0)
    expected = problem.d2g(x, y, z)
    scale = np.abs(problem.d2g(x, y, y)).max() + np.abs(problem.d2g(x, z, z)).max()
    for name, given, value in (("rows", rows, expected), ("sum", total, (c * expected).sum(axis=0))):
        if not np.allclose(given, value, rtol=1e-6, atol=1e-8 * scale):
            raise ProblemError(f"structure: curvature_{name} disagrees with the second derivative of constraint")
