"""Common base of schemes for Langevin dynamics that solve for a multiplier."""

from dataclasses import dataclass

import numpy as np

from sdaeverify import Array, Claim, ConstraintGeometry, ParameterError, Step

from ._langevin_noise import LangevinScheme
from ._multiplier import OldNormals
from ._turning_normals import TurningNormals


@dataclass(frozen=True)
class ImplicitLangevin(LangevinScheme):
    """Base of schemes that end with x' = y + g lambda, zeta(x') = level.

    Attributes
    ----------
    solver : str
        ``newton``, or ``frozen`` for the Gram matrix of the old point in every iteration.
    no_root : str
        Treatment of a path without admissible root, which is counted in any case: ``hold`` keeps its state, ``fail``
        makes it NaN. Drawing a new xi is not possible, because a step is a function of the given xi.
    """

    solver: str = "newton"
    no_root: str = "hold"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.solver not in {"newton", "frozen"}:
            raise ParameterError(f"solver must be newton or frozen, got {self.solver!r}")
        if self.no_root not in {"hold", "fail"}:
            raise ParameterError(f"no_root must be hold or fail, got {self.no_root!r}")
        if self.solver == "frozen" and self.implicitness:
            raise ParameterError("solver=frozen needs the normals at the old point")

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims, without that of few iterations if the matrix is frozen."""
        kept = super().promises
        return kept if self.solver == "newton" else tuple(claim for claim in kept if claim.measure != "effort")

    @property
    def implicitness(self) -> float:
        """Parameter theta of the point x + theta (x' - x) at which normals are taken."""
        return 0.0

    def onto(self, at: ConstraintGeometry, y: Array, level: Array) -> Step:
        """Return the step from the point of `at` to y + g lambda on the level set."""
        if self.implicitness:
            new = TurningNormals(at, y, level, self.implicitness).solve()
        else:
            new = OldNormals(at, y, level).solve(frozen=self.solver == "frozen")
        kept = at.x if self.no_root == "hold" else np.nan
        return Step(
            np.where(new.found, new.x, kept),
            ~new.found,
            costs={"newton_iterations": new.matrices, "updates": new.updates},
        )
