"""The uniformly accurate integrator with multipliers that cost too much, or the more the smaller eps is."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, ConstraintGeometry, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.penalised._multiplier import OldNormals
from sdaeverify_schemes.penalised.uniformly_accurate import UniformlyAccurate


@dataclass(frozen=True)
class Led(UniformlyAccurate):
    """The level is approached in parts: one for each halving of eps below a step, or a fixed number.

    Attributes
    ----------
    stages : int
        The fixed number; 0 for as many as eps asks for.
    """

    stages: int = 0

    name: ClassVar[str] = "planted-uniform-led"

    def onto(self, at: ConstraintGeometry, y: Array, level: Array) -> Step:
        """Return the step from the point of `at` to y + g lambda on the level set.

        Parameters
        ----------
        at : ConstraintGeometry
            Of the old point.
        y : ndarray, shape (d, P)
            Where the step without constraint leads.
        level : ndarray, shape (q, P)
            Value zeta of the level set.
        """
        halvings = int(np.ceil(np.log2(1.0 / at.problem.eps))) if at.problem.eps else 1
        new = OldNormals(at, y, level).follow(self.stages or max(1, halvings))
        return Step(
            np.where(new.found, new.x, at.x),
            ~new.found,
            costs={"newton_iterations": new.matrices, "updates": new.updates},
        )


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="iterations that grow as eps tends to 0", scheme=Led(), problem="affine-constraint"),
        Planted(bug="three times as many iterations", scheme=Led(stages=24), problem="affine-constraint"),
    ]
