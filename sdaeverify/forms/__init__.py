"""Forms: the mathematical shapes a problem can have, and the views between them."""

from .constrained_langevin import ConstrainedLangevin
from .constraint_geometry import ConstraintGeometry
from .constraint_jacobian import ConstraintJacobian, DenseJacobian, Gram
from .holonomic import HolonomicSDAE, HolonomicState
from .langevin import Langevin
from .problem import TRAITS, Problem, Residual
from .sde import SDE
from .structure import Structure

__all__ = [
    "SDE",
    "TRAITS",
    "ConstrainedLangevin",
    "ConstraintGeometry",
    "ConstraintJacobian",
    "DenseJacobian",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "Langevin",
    "Problem",
    "Residual",
    "Structure",
]
