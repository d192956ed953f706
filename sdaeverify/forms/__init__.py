"""Forms: the types of equations a problem can have, and the views between them."""

from ..noise.brownian import BROWNIAN
from .delay.delay_sdae import DelaySDAE, DelayState
from .delay.delayed import Delayed, IndexOne
from .delay.dissipation import Dissipation
from .delay.index_one import IndexOneSDAE
from .delay.mesh import Lag, Mesh
from .delay.partials import Partials
from .domain import Domain, outside, why_not_within
from .equation import Equation
from .langevin.langevin import Damped, Langevin
from .manifold import LevelSets
from .mechanics.holonomic import HolonomicSDAE, HolonomicState
from .mechanics.jacobian import ConstraintJacobian, DenseJacobian, Gram
from .mechanics.multiplied import Multiplied
from .mechanics.structure import Structure
from .overdamped.constrained_langevin import ConstrainedLangevin, ConstraintGeometry
from .overdamped.stiffness_family import Penalised, StiffnessFamily
from .problem import Problem, Residual, components
from .sde.sde import SDE, as_sde
from .traits import known_traits, why_unknown

__all__ = [
    "BROWNIAN",
    "SDE",
    "ConstrainedLangevin",
    "ConstraintGeometry",
    "ConstraintJacobian",
    "Damped",
    "DelaySDAE",
    "DelayState",
    "Delayed",
    "DenseJacobian",
    "Dissipation",
    "Domain",
    "Equation",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "IndexOne",
    "IndexOneSDAE",
    "Lag",
    "Langevin",
    "LevelSets",
    "Mesh",
    "Multiplied",
    "Partials",
    "Penalised",
    "Problem",
    "Residual",
    "StiffnessFamily",
    "Structure",
    "as_sde",
    "components",
    "known_traits",
    "outside",
    "why_not_within",
    "why_unknown",
]
