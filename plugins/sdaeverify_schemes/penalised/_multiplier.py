"""Steps onto a level set of the constraint along normals at the old point."""

from collections.abc import Callable, Container
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from sdaeverify import Array, ConstraintGeometry, Gram, Mask

from ._chords import Ending, iterate
from ._reached import Reached

# Largest number of iterations: few for quadratic convergence, many for the linear one of a frozen matrix.
FEW, MANY = 30, 100
NEWTON = range(FEW)
# Number of constraints above which Newton's matrix costs more than the constraint. The first matrix is then used
# three times and the next one six times, which usually suffices.
CHEAP, CHORDS = 2, (3, 9, 15, *range(21, FEW))
# If the second update is longer than the first, the iteration may reach a wrong root. The level is then moved in
# PARTS stages until the updates of each stage shrink by at least a half.
PARTS, SURE = (4, 32), 0.5


@dataclass(frozen=True, eq=False)
class OldNormals:
    """The equation zeta(y + g(x) lambda) = level.

    Attributes
    ----------
    at : ConstraintGeometry
        Geometry at x.
    y : ndarray, shape (d, P)
    level : ndarray, shape (q, P)
    """

    at: ConstraintGeometry
    y: Array
    level: Array

    def solve(self, *, frozen: bool = False) -> Reached:
        """Return y + g(x) lambda, by Newton's method.

        If `frozen`, the matrix is g(x)^T g(x) throughout; roots are then distinguished only by their distance.
        """
        if frozen:
            return Reached.by(self._iterate(self.y, (), MANY, self.at.gram), self.y)
        return self.search()

    def search(self) -> Reached:
        """Return y + g(x) lambda, by Newton's method from lambda = 0 with the matrix g(x')^T g(x).

        With several constraints, doubtful roots are recomputed by continuation from lambda = 0.
        """
        if len(self.level) <= CHEAP:
            return Reached.by(self._iterate(self.y, NEWTON), self.y)
        end = self._iterate(self.y, CHORDS)
        reached = Reached.by(end, self.y)
        sure = reached.found & (end.second <= end.first)
        for parts in PARTS:
            reached = self._search_again(reached, ~sure, partial(OldNormals.follow, parts=parts))
            sure |= reached.found
        return reached

    def follow(self, parts: int) -> Reached:
        """Return y + g(x) lambda by continuation.

        The level moves from zeta(y) in `parts` stages, and det > 0 is required at each of them.
        """
        begin, z = self.at.problem.constraint(self.y), self.y.copy()
        found, counts = np.ones(z.shape[1], dtype=bool), np.zeros((2, z.shape[1]), dtype=np.int64)
        for part in np.arange(1, parts + 1) / parts:
            towards = replace(self, level=begin + part * (self.level - begin))
            # Two updates reveal unsafe paths; only the others are iterated to convergence.
            for most in (2, FEW):
                where = np.flatnonzero(found)
                if not len(where):
                    return Reached(z, found, *counts)
                end = towards._part(where)._iterate(z[:, where], NEWTON, most)
                found[where] &= end.second <= SURE * end.first
            found[where] &= end.converged & end.last.positive()
            z[:, where] = end.x
            counts[:, where] += end.updates, end.matrices
        return Reached(z, found, *counts)

    def _part(self, where: Array) -> "OldNormals":
        at = self.at.problem.near(self.at.x[:, where])
        return OldNormals(at, self.y[:, where], self.level[:, where])

    def _search_again(self, reached: Reached, where: Mask, search: Callable[["OldNormals"], Reached]) -> Reached:
        if not where.any():
            return reached
        return reached.merge(where, search(self._part(np.flatnonzero(where))))

    def _iterate(self, z: Array, anew: Container[int], most: int = FEW, frozen: Gram | None = None) -> Ending:
        problem = self.at.problem
        return iterate(lambda z: _Local(self, problem.near(z), frozen), z, anew, most)


@dataclass(frozen=True, eq=False)
class _Local:
    equation: OldNormals
    new: ConstraintGeometry
    frozen: Gram | None

    @property
    def defect(self) -> Array:
        return self.new.zeta - self.equation.level

    def update(self, defect: Array) -> Array:
        return self.equation.at.J.transposed(self._gram.solve(defect))

    def positive(self) -> Mask:
        return self._gram.positive()

    @cached_property
    def _gram(self) -> Gram:
        return self.frozen or self.new.J.gram(self.equation.at.J)
