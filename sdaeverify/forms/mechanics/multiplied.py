"""Capabilities of problems whose constraint is enforced by multipliers, and further ones of mechanics."""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from numpy.typing import ArrayLike

from ...arrays import Array
from ..manifold import LevelSets


class Multiplied(LevelSets):
    """An Ito equation with a component ``mu`` that is the multiplier of a constraint."""

    absent: ClassVar[str] = "has no multiplier"

    @abstractmethod
    def multiplier_scales(self, t: float, x: Array, h: float) -> tuple[Array, Array]:
        """Return the sizes of the terms that cancel in a step's multiplier: in its value, and in its change.

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


class Mechanics(Multiplied):
    """Positions r and velocities v of bodies under a force a(t, r, v) and a constraint g(r) = 0."""

    force: Callable[[float, Array, Array], Array]
    mass: ArrayLike | None
    force_derivatives: Callable[[float, Array, Array], tuple[Array, Array]] | None

    @property
    @abstractmethod
    def dimension(self) -> int:
        """Return the number n of positions."""

    @property
    @abstractmethod
    def constraints(self) -> int:
        """Return the number m of constraints."""

    @abstractmethod
    def inverse_mass(self, y: Array) -> Array:
        """Return M^{-1} y for y of shape (n, P) or (n, l, P)."""

    @abstractmethod
    def d2g(self, r: Array, y: Array, z: Array) -> Array:
        """Return D^2 g(r)(y, z), shape (m, P).

        Parameters
        ----------
        r : ndarray, shape (n, P)
        y, z : ndarray, shape (n, P)
            Directions; the derivative is bilinear and symmetric in them.
        """

    @abstractmethod
    def why_not_derivative_of_force(self) -> str:
        """Return why the derivatives of the force cannot be taken, or an empty string."""
