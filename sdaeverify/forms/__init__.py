"""Forms: the mathematical shapes a problem can have, and the views between them."""

from .constraint_jacobian import ConstraintJacobian, DenseJacobian, Gram
from .holonomic import HolonomicSDAE, HolonomicState
from .langevin import Langevin
from .problem import TRAITS, Problem, Residual
from .sde import SDE

__all__ = [
    "SDE",
    "TRAITS",
    "ConstraintJacobian",
    "DenseJacobian",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "Langevin",
    "Problem",
    "Residual",
]
