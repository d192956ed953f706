"""What is known exactly of a problem, attached to it so that every measure can ask for it."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from ..arrays import Array, Parts
from ..errors import ProblemError
from ..noise.brownian import Increment


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
        The components it knows, under the names the problem uses.
    order : float
        Strong order of the truth as a scheme; infinite if it is exact at grid times.
    extra_normals : int
        Rows of `Increment.xi` it needs a step: functionals of W beyond dW and H.
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
        """Whether it has no error of its own at grid times."""
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
class MeanSquareStability:
    """Whether the second moment of the solution tends to zero.

    Attributes
    ----------
    stable : bool
    source : str
    """

    stable: bool
    source: str


Truth = Pathwise | Moment | InvariantMean | MeanSquareStability
