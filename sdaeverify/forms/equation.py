"""The interface of an Ito equation, independent of its class."""

from collections.abc import Callable, Hashable, Mapping
from typing import Protocol

from ..arrays import Array, Parts
from ..noise.brownian import Increment


class Equation(Hashable, Protocol):
    """dx = f dt + B dW (Ito) for all comparable components of a problem, represented by its coefficients.

    Attributes
    ----------
    drift : callable, (t, x) -> ndarray, shape (d, P)
    diffusion : callable, (t, x) -> ndarray, shape (d, l, P) or (d, l, 1)
    noise_dim, dimension : int
        l and d.
    horizon : float
    names : mapping of str to slice, or None
        Rows of the named components; ``x`` for all of them if None.
    """

    @property
    def drift(self) -> Callable[[float, Array], Array]:
        """Return f."""

    @property
    def diffusion(self) -> Callable[[float, Array], Array]:
        """Return B."""

    @property
    def noise_dim(self) -> int:
        """Return l."""

    @property
    def dimension(self) -> int:
        """Return d."""

    @property
    def horizon(self) -> float:
        """Return the final time."""

    @property
    def names(self) -> Mapping[str, slice] | None:
        """Return the rows of the components."""

    def initial(self, paths: int) -> Array:
        """Return the initial state on every path, shape (d, P)."""

    def parts(self, x: Array, /) -> Parts:
        """Return the named components of a state."""

    def coefficients(self, t: float, x: Array) -> tuple[Array, ...]:
        """Return drift, diffusion and any further coefficients of the equation."""

    def diffused(self, t: float, x: Array, w: Array) -> Array:
        """Return B(t, x) w, shape (d, P).

        Parameters
        ----------
        t : float
        x : ndarray, shape (d, P)
        w : ndarray, shape (l, P)
            Factor of B, such as an increment of the Brownian motions.
        """

    def euler(self, t: float, x: Array, h: float, noise: Increment) -> Array:
        """Return x after a step of size h of Euler's method, shape (d, P).

        Parameters
        ----------
        t : float
            Start of the step.
        x : ndarray, shape (d, P)
        h : float
            Its size, in the problem's unit of time.
        noise : Increment
            Of the step.
        """
