"""Capabilities of problems whose coefficients depend on x, on its past v and on algebraic components y."""

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array, Parts
from ...noise.brownian import Increment
from ...numerics.digits import unit_of
from ..problem import Problem
from ..traits import INDEX_ONE
from .dissipation import Dissipation
from .mesh import Lag, Mesh
from .partials import Partials


class IndexOne(Problem):
    """dx = f(t, x, v, y) dt + g(t, x, v, y) dW, 0 = u(t, x, v, y), v = x(t - delay): with or without y and delay."""

    absent: ClassVar[str] = "has no algebraic components"
    declared_traits = INDEX_ONE

    delay: float
    constraint: Callable[[float, Array, Array, Array], Array] | None
    solved: Callable[[float, Array, Array], Array] | None
    drift_partials: Callable[[float, Array, Array, Array], Partials] | None
    constraint_partials: Callable[[float, Array, Array, Array], Partials] | None
    dissipation: Dissipation | None
    dissipation_without_y: Dissipation | None
    drift: Callable[[float, Array, Array, Array], Array]
    diffusion: Callable[[float, Array, Array, Array], Array]

    @property
    @abstractmethod
    def dimension(self) -> int:
        """Return the number d of components of x."""

    @property
    @abstractmethod
    def constraints(self) -> int:
        """Return the number q of components of y."""

    @property
    @abstractmethod
    def reduced_dissipation(self) -> Dissipation | None:
        """Return the constants of the equation with y eliminated."""

    @abstractmethod
    def initial(self, paths: int) -> Any:
        """Return the state at time 0 on every path."""

    @abstractmethod
    def parts(self, state: Any) -> Parts:
        """Return the named components of a state."""

    @abstractmethod
    def past(self, t: float) -> Array:
        """Return x at a time t <= 0, shape (d, 1)."""

    @abstractmethod
    def mesh(self, h: float) -> Mesh:
        """Return the position of the delay on a grid of steps of size h."""

    @abstractmethod
    def lag(self, x: Array, h: float, noise: Increment) -> Lag:
        """Return the lagged values of a step of size h from x, driven by `noise`.

        Parameters
        ----------
        x : ndarray, shape (d, P)
            The solution at the start of the step; the lagged value itself if the delay is 0.
        h : float
            Step size, in the problem's unit of time.
        noise : Increment
            Of this step: it contains the lagged values.
        """

    @abstractmethod
    def eliminated(self, t: float, x: Array, v: Array) -> Array:
        """Return the y that solves the constraint, shape (q, P).

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)
            The solution at t, and one delay before t.

        Raises
        ------
        ProblemError
            If the equation has no algebraic component.
        """

    @abstractmethod
    def diffused(self, t: float, x: Array, v: Array, y: Array, w: Array) -> Array:
        """Return g(t, x, v, y) w, shape (d, P).

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)
            The solution at t, and one delay before t.
        y : ndarray, shape (q, P)
            Algebraic components at t.
        w : ndarray, shape (l, P)
            Factor of g, such as an increment of the Brownian motions.
        """

    @abstractmethod
    def linearised_constraint(self, t: float, x: Array, v: Array, y: Array) -> Partials:
        """Return the derivatives of u in x, v and y.

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)
            The solution at t, and one delay before t.
        y : ndarray, shape (q, P)
            Algebraic components at t: u need not vanish there.

        Raises
        ------
        ProblemError
            If the equation has no algebraic component.
        """

    @abstractmethod
    def without_y(self) -> "IndexOne":
        """Return the equation with y eliminated."""

    @abstractmethod
    def consistent(self, t: float, x: Array, v: Array) -> Any:
        """Return the state at x and v with the y that solves the constraint.

        Parameters
        ----------
        t : float
        x, v : ndarray, shape (d, P)
            The solution at t, and one delay before t.
        """

    def near_past(self, rng: np.random.Generator, paths: int, spread: float) -> dict[str, Any]:
        """Draw lagged values of a step around x at time 0, by their names in `Increment`; empty without delay.

        Parameters
        ----------
        rng : numpy.random.Generator
        paths : int
            Number P of paths.
        spread : float
            Standard deviation of the lagged values around the start, relative to the size of x.
        """
        x = np.repeat(self.past(0.0), paths, axis=1)
        drawn = x + spread * unit_of(float(np.abs(x).max())) * rng.standard_normal((2, *x.shape))
        return dict(zip(("lagged", "ahead"), drawn, strict=True)) if self.delay else {}


class Delayed(IndexOne):
    """An `IndexOne` problem with a delay."""

    absent: ClassVar[str] = "has no delay"
