"""Forms: the mathematical shapes a problem can have, and the views between them."""

from .delay.delay_sdae import DelaySDAE, DelayState, is_delayed
from .delay.dissipation import Dissipation
from .delay.mesh import Lag, Mesh
from .delay.partials import Partials
from .langevin.langevin import Langevin
from .mechanics.holonomic import HolonomicSDAE, HolonomicState
from .mechanics.jacobian import ConstraintJacobian, DenseJacobian, Gram
from .mechanics.structure import Structure
from .overdamped.constrained_langevin import ConstrainedLangevin
from .overdamped.geometry import ConstraintGeometry
from .problem import NOISE, TRAITS, Problem, Residual, components
from .sde.sde import SDE

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
