"""Forms: the mathematical shapes a problem can have, and the views between them."""

from .delay.delay_sdae import DelaySDAE, DelayState
from .delay.delayed import Delayed, IndexOne
from .delay.dissipation import Dissipation
from .delay.mesh import Lag, Mesh
from .delay.partials import Partials
from .equation import Equation
from .langevin.langevin import Langevin
from .mechanics.holonomic import HolonomicSDAE, HolonomicState
from .mechanics.jacobian import ConstraintJacobian, DenseJacobian, Gram
from .mechanics.multiplied import Multiplied
from .mechanics.structure import Structure
from .overdamped.constrained_langevin import ConstrainedLangevin
from .overdamped.family import StiffnessFamily
from .overdamped.geometry import ConstraintGeometry
from .problem import BROWNIAN, TRAITS, Problem, Residual, components
from .sde.sde import SDE

__all__ = [
    "BROWNIAN",
    "SDE",
    "TRAITS",
    "ConstrainedLangevin",
    "ConstraintGeometry",
    "ConstraintJacobian",
    "DelaySDAE",
    "DelayState",
    "Delayed",
    "DenseJacobian",
    "Dissipation",
    "Equation",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "IndexOne",
    "Lag",
    "Langevin",
    "Mesh",
    "Multiplied",
    "Partials",
    "Problem",
    "Residual",
    "StiffnessFamily",
    "Structure",
    "components",
]
