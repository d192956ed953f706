"""What a problem offers that is one of a family with every stiffness parameter."""

from abc import abstractmethod
from typing import Any, ClassVar

from ...arrays import Array
from ..equation import Equation
from ..manifold import LevelSets


class Penalised(LevelSets):
    """Dynamics on level sets that are left or kept: with ``eps``, ``strength``, ``turn_normals`` and ``traces``."""

    absent: ClassVar[str] = "has no constraint that is penalised"


class StiffnessFamily(Penalised):
    """Noise of one strength in every component, and a constraint kept by a force of size 1/eps; 0 in the limit."""

    absent: ClassVar[str] = "has no stiffness parameter"

    eps: float
    strength: float

    @property
    @abstractmethod
    def dimension(self) -> int:
        """Return the number of components."""

    @property
    @abstractmethod
    def constraints(self) -> int:
        """Return the number of constraints."""

    @abstractmethod
    def ito(self) -> Equation:
        """Return the equation of all components."""

    @abstractmethod
    def initial(self, paths: int) -> Array:
        """Return the initial state on every path."""

    @abstractmethod
    def parts(self, x: Array) -> Any:
        """Return the named components of a state."""

    @abstractmethod
    def member(self, eps: float) -> "StiffnessFamily":
        """Return the same problem, its truths included, with another eps."""
