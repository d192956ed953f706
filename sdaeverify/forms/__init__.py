"""Forms: the mathematical shapes a problem can have, and the views between them."""

from .constrained_langevin import ConstrainedLangevin
from .constraint_geometry import ConstraintGeometry
from .constraint_jacobian import ConstraintJacobian, DenseJacobian, Gram
from .delay import DelaySDAE, DelayState, is_delayed
from .delay_mesh import Lag, Mesh
from .dissipation import Dissipation
from .holonomic import HolonomicSDAE, HolonomicState
from .langevin import Langevin
from .partial_derivatives import Partials
from .problem import NOISE, TRAITS, Problem, Residual, components
from .sde import SDE
from .structure import Structure

__all__ = [
    "NOISE",
    "SDE",
    "TRAITS",
    "ConstrainedLangevin",
    "ConstraintGeometry",
    "ConstraintJacobian",
    "DelaySDAE",
    "DelayState",
    "DenseJacobian",
    "Dissipation",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "Lag",
    "Langevin",
    "Mesh",
    "Partials",
    "Problem",
    "Residual",
    "Structure",
    "components",
    "is_delayed",
]
