"""Whether a problem couples what its structure says, checked where the problem is built."""

from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...errors import ProblemError
from ..checks import PROBES, check_derivative, check_shape, wave
from .structure import Structure, no_derivative_of_force

if TYPE_CHECKING:
    from .holonomic import HolonomicSDAE


def check_structure(problem: "HolonomicSDAE", r: Array, v: Array) -> None:
    """Check that a problem couples no more than it says, and that an author's derivatives are those of its functions.

    Raises
    ------
    ProblemError
        If the numbers of nodes and owners do not fit, if the mass couples nodes, or if a derivative disagrees.
    """
    structure, n = problem.blocks, problem.dimension
    if n % structure.nodes or len(structure.owners) != problem.constraints:
        given = f"{structure.nodes} nodes and {len(structure.owners)} owners"
        raise ProblemError(f"structure has {given}, the problem {n} positions and {problem.constraints} constraints")
    if problem.mass is not None and structure.nodes > 1:
        _check_mass(structure, problem)
    if problem.force_derivatives is not None:
        for name, value in zip(("r", "v"), problem.force_derivatives(0.0, r, v), strict=True):
            check_shape(f"force_derivatives(t, r, v), by {name},", value, (n, n, PROBES))
    if problem.structure is None and problem.force_derivatives is None:
        return
    if not no_derivative_of_force(problem):
        _check_force(structure, problem, np.concatenate([r, v]))
    _check_constraint(structure, problem, r)


def _check_mass(structure: Structure, problem: "HolonomicSDAE") -> None:
    y = wave((problem.dimension, PROBES))
    blocks = structure.inverse_mass_blocks(problem)
    assert blocks is not None
    if not np.allclose(blocks.times(structure.by_node(y)).reshape(y.shape), problem.inverse_mass(y), rtol=1e-12):
        raise ProblemError("structure: the mass couples nodes, which it must not; leave structure out")


def _check_force(structure: Structure, problem: "HolonomicSDAE", x: Array) -> None:
    n, t = problem.dimension, 0.5 * problem.horizon

    def force(z: Array) -> Array:
        return np.broadcast_to(problem.force(t, z[:n], z[n:]), z[:n].shape)

    def derivative(z: Array, y: Array) -> Array:
        by_r, by_v = structure.force_blocks(problem, t, z[:n], z[n:])
        change = by_r.times(structure.by_node(y[:n])) + by_v.times(structure.by_node(y[n:]))
        return np.broadcast_to(change.reshape(n, -1), z[:n].shape)

    check_derivative("the derivative of force by its structure", force, derivative, x)


def _check_constraint(structure: Structure, problem: "HolonomicSDAE", r: Array) -> None:
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
