"""Forms: the mathematical shapes a problem can have, and the views between them."""

from .holonomic import HolonomicSDAE, HolonomicState
from .langevin import Langevin
from .problem import TRAITS, Problem, Residual
from .sde import SDE

__all__ = ["SDE", "TRAITS", "HolonomicSDAE", "HolonomicState", "Langevin", "Problem", "Residual"]
