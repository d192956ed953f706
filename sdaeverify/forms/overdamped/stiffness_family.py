"""Capabilities of problems that belong to a family with a stiffness parameter."""

from abc import abstractmethod
from typing import Any, ClassVar

from ...arrays import Array
from ..equation import Equation
from ..manifold import LevelSets


class Penalised(LevelSets):
    """Dynamics near or on level sets: with ``eps``, ``strength``, ``turn_normals`` and ``traces``."""

    absent: ClassVar[str] = "has no constraint that is penalised"


class StiffnessFamily(Penalised):
    """Dynamics with noise of one strength in every component, and a penalty force of size 1/eps; exact at eps = 0."""

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
