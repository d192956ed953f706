"""Truths: exact knowledge about a problem, attached to it for use by all measures."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from ..arrays import Array, Parts
from ..errors import ProblemError
from ..noise.brownian import Increment
from ..numerics.derivatives import directional, second_directional


@dataclass(frozen=True, kw_only=True)
class Pathwise:
    """The solution on a given Brownian path, exact or by a fine reference scheme.

    Attributes
    ----------
    start : callable, P -> ndarray, shape (k, P)
        Initial state of the truth on P paths.
    advance : callable, (z, t, h, noise) -> ndarray, shape (k, P)
        State one step later, from the state z, the time t and an `Increment`.
    parts : callable, (t, z) -> mapping of str to ndarray, shape (n, P)
        Its components, under the problem's names.
    order : float
        Strong order of the truth as a scheme; infinite if it is exact at grid times.
    extra_normals : int
        Rows of `Increment.xi` it needs per step: functionals of W other than dW and H.
    source : str
    """

    start: Callable[[int], Array]
    advance: Callable[[Array, float, float, Increment], Array]
    parts: Callable[[float, Array], Parts]
    source: str
    order: float = inf
    extra_normals: int = 0

    def __post_init__(self) -> None:
        if not self.order > 0.0:
            raise ProblemError(f"the order of a pathwise truth must be positive, got {self.order!r}")
        if self.extra_normals and not self.exact:
            raise ProblemError(
                "a pathwise truth of finite order cannot use extra normals: two resolutions must agree"
            )

    @property
    def exact(self) -> bool:
        """Whether it has no discretisation error at grid times."""
        return self.order == inf


@dataclass(frozen=True, kw_only=True)
class Moment:
    """The expectation of an observable at every time.

    Attributes
    ----------
    observable : str
        Name of one of the problem's observables.
    value : callable, t -> float
    source : str
    """

    observable: str
    value: Callable[[float], float]
    source: str


@dataclass(frozen=True, kw_only=True)
class InvariantMean:
    """The expectation of an observable under the invariant law.

    Attributes
    ----------
    observable : str
        Name of one of the problem's observables.
    value : float
    source : str
    """

    observable: str
    value: float
    source: str


@dataclass(frozen=True, kw_only=True)
class MomentEquation:
    """The Stein identity E [L phi] = 0 of an observable phi under the invariant law, where L is the generator.

    L phi = f . grad phi + (1/2) sum_j D^2 phi (b_j, b_j), b_j being the columns of B. phi = q . p gives the virial
    theorem, phi = U the configurational temperature. The mean of phi itself need not be known. The identity requires
    a law under which phi and L phi have means, and an observable that is analytic in the equation's components.

    Attributes
    ----------
    observable : str
        Name of phi, one of the problem's observables.
    source : str
    """

    observable: str
    source: str

    @property
    def name(self) -> str:
        """Name of L phi among the quantities of the measure ``invariant``."""
        return f"L {self.observable}"


@dataclass(frozen=True, kw_only=True)
class MeanSquareStability:
    """Whether the second moment of the solution tends to zero.

    Attributes
    ----------
    stable : bool
    source : str
    """

    stable: bool
    source: str


Truth = Pathwise | Moment | InvariantMean | MomentEquation | MeanSquareStability


def generator_of(equation: Any, observable: Callable[[float, Parts], Array]) -> Callable[[float, Parts], Array]:
    """Return L phi as an observable of the same components.

    Parameters
    ----------
    equation : Equation
    observable : callable, (t, parts) -> ndarray, shape (P,)
        phi, analytic in the components of the equation.
    """
    names = list(equation.names or ("x",))

    def applied(t: float, parts: Parts) -> Array:
        x = np.concatenate([parts[name] for name in names])

        def phi(at: Array) -> Array:
            return np.asarray(observable(t, equation.parts(at)))

        B = np.broadcast_to(equation.diffusion(t, x), (len(x), equation.noise_dim, x.shape[-1]))
        columns = (B[:, j] for j in range(equation.noise_dim))
        curved = sum((second_directional(phi, x, b, b) for b in columns if b.any()), np.zeros(x.shape[-1]))
        return directional(phi, x, equation.drift(t, x)) + 0.5 * curved

    return applied
