"""Steps onto a level set of the constraint along normals at an intermediate or new point."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, ConstraintGeometry, Mask
from sdaeverify.numerics import apply, determinant, solve

from ._chords import iterate
from ._multiplier import FEW, NEWTON
from ._reached import Reached


@dataclass(frozen=True, eq=False)
class TurningNormals:
    """The equations x' = y + g(x + theta (x' - x)) lambda, zeta(x') = level.

    Attributes
    ----------
    at : ConstraintGeometry
        Geometry at x.
    y : ndarray, shape (d, P)
    level : ndarray, shape (q, P)
    theta : float
    """

    at: ConstraintGeometry
    y: Array
    level: Array
    theta: float

    def solve(self) -> Reached:
        """Solve for x' by Newton's method from x' = y, lambda = 0."""
        return Reached.by(iterate(self._local, self.y, NEWTON, FEW), self.y)

    def _local(self, z: Array) -> "_Local":
        x, problem = self.at.x, self.at.problem
        new = problem.near(z)
        return _Local(self, new, new if self.theta == 1.0 else problem.near(x + self.theta * (z - x)))


class _System(NamedTuple):
    """Newton's matrix [[A, -g], [J, 0]], A = Id - theta sum_k lambda_k H_k, with its Schur complement J A^{-1} g."""

    A: Array
    Ag: Array
    Ar: Array
    schur: Array


@dataclass(frozen=True, eq=False)
class _Local:
    """The linearisation at x', with the multiplier that solves the first equation best in the directions J = g(x')^T.

    The residual r = y + g lambda - x' satisfies J r = 0. An update solves A dx - g dlambda = r and
    J dx = level - zeta(x').
    """

    equation: TurningNormals
    new: ConstraintGeometry
    between: ConstraintGeometry

    @property
    def defect(self) -> Array:
        return self.new.zeta - self.equation.level

    def update(self, defect: Array) -> Array:
        _, Ag, Ar, schur = self._system
        return apply(Ag, solve(schur, defect + self.new.J.times(Ar))) - Ar

    def positive(self) -> Mask:
        return np.asarray(determinant(self._system.A) * determinant(self._system.schur) > 0.0)

    @cached_property
    def _system(self) -> _System:
        (moved, J), between = (self.new.x - self.equation.y, self.new.J), self.between
        d, q, paths = len(moved), len(self.new.zeta), moved.shape[1]
        g = np.broadcast_to(between.problem.dg(between.x), (q, d, paths)).swapaxes(0, 1)
        lam = J.gram(between.J).solve(J.times(moved))
        A = np.eye(d)[..., None] - self.equation.theta * between.problem.bent(between.x, lam)
        both = solve(A, np.concatenate([g, (apply(g, lam) - moved)[:, None]], axis=1))
        return _System(A, both[:, :q], both[:, q], J.times(both[:, :q]))
