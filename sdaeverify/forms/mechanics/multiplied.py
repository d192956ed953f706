"""What a problem offers whose constraint is kept by multipliers."""

from abc import abstractmethod
from typing import ClassVar

from ...arrays import Array
from ..manifold import LevelSets


class Multiplied(LevelSets):
    """An Ito equation with a component ``mu`` that is the multiplier of a constraint."""

    absent: ClassVar[str] = "has no multiplier"

    @abstractmethod
    def multiplier_scales(self, t: float, x: Array, h: float) -> tuple[Array, Array]:
        """Return the sizes of what cancels in a multiplier of one step: of its value, and of its change by the step.

        Parameters
        ----------
        t : float
        x : ndarray, shape (d, S)
            States, rows in the order of the Ito equation's names.
        h : float

        Returns
        -------
        ndarray, shape (S,), twice
        """
