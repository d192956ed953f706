"""What problems of every form have in common.

Traits are facts a claim may ask for; the conformance tests check each of them by evaluating the problem:

``scalar-noise``
    One Brownian motion (set by the form itself).
``diagonal-noise``
    The diffusion matrix is diagonal and its j-th entry depends on component j alone.
``additive-noise``
    The diffusion matrix depends neither on the state nor on time.
``vanishing-milstein-term``
    DB_j(x) B_k(x) = 0 for all columns of the diffusion of the SDE (of the inherent SDE, for a constrained
    problem), so that Euler-Maruyama is Milstein's scheme.
``normal-milstein-term``
    DB_j(x) B_k(x) is orthogonal to the manifold g = 0 of an SDE's constraint, at points x of it, so that a
    projection supplies what Euler-Maruyama lacks.
``unconstrained``
    No constraint was eliminated or left to the scheme (set by the form itself): what does not project cannot leave
    a manifold in the long run.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Parts
from ..chart import Chart
from ..controls import Control
from ..errors import ProblemError
from ..numerics import matches_differences
from ..truths import InvariantMean, Moment, Pathwise, Truth

Observable = Callable[[float, Parts], Array]

TRAITS = frozenset(
    {
        "scalar-noise",
        "diagonal-noise",
        "additive-noise",
        "vanishing-milstein-term",
        "normal-milstein-term",
        "unconstrained",
    }
)
NOISE = frozenset({"dW", "H"})
PROBES = 3
# Rounding alone leaves a few eps; a start further off the manifold is a mistake, not a rounding.
CONSISTENCY = 1e4 * np.finfo(float).eps


class Residual(NamedTuple):
    """A constraint's defect and the size of the terms that cancel in it.

    Attributes
    ----------
    value : ndarray, shape (m, P)
    scale : ndarray, shape (P,)
        Rounding errors of `value` are a few eps times this.
    """

    value: Array
    scale: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """Data, observables and truths of a problem of any form.

    Attributes
    ----------
    horizon : float
        Final time T, in the problem's unit of time.
    noise_dim : int
        Number l of independent Brownian motions.
    source : str
        Where the problem is from, with equation number.
    units : str
    traits : frozenset of str
    noise : frozenset of str
        What is drawn for it: ``dW``, and ``H`` unless it is left out to save half of the random numbers. It belongs
        to the problem, so that no scheme's paths depend on which other schemes take part.
    observables : mapping of str to callable, (t, parts) -> ndarray, shape (P,)
    truths : tuple of Truth
    controls : tuple of Control
        One for each order of a measure that may be gated on it.
    chart : Chart, optional
        One or two coordinates that all components but pure outputs are functions of.
    relaxation : float
        Time in which the solution forgets its start by a factor e, in the problem's unit of time; infinite where
        it has no invariant law, or none that is known.
    seen_as : str
        What it is a view of another problem as; empty for a problem of its own.
    """

    horizon: float
    noise_dim: int
    source: str
    units: str = "dimensionless"
    traits: frozenset[str] = frozenset()
    noise: frozenset[str] = NOISE
    observables: Mapping[str, Observable] = field(default_factory=dict)
    truths: tuple[Truth, ...] = ()
    controls: tuple[Control, ...] = ()
    chart: Chart | None = None
    relaxation: float = np.inf
    seen_as: str = ""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.horizon) and self.horizon > 0):
            raise ProblemError(f"horizon must be a positive time, got {self.horizon!r}")
        if not (np.issubdtype(type(self.noise_dim), np.integer) and self.noise_dim >= 1):
            raise ProblemError(f"noise_dim must be a whole number of at least 1, got {self.noise_dim!r}")
        if not {"dW"} <= self.noise <= NOISE:
            raise ProblemError(f"noise must be dW or dW and H, got {sorted(self.noise)}")
        object.__setattr__(self, "traits", self._all_traits())
        for truth in self.truths:
            if isinstance(truth, Moment | InvariantMean) and truth.observable not in self.observables:
                known = sorted(self.observables)
                raise ProblemError(f"a truth is about observable {truth.observable!r}; known are {known}")

    def _all_traits(self) -> frozenset[str]:
        traits = frozenset(self.traits) | ({"scalar-noise"} if self.noise_dim == 1 else frozenset())
        if unknown := traits - TRAITS:
            raise ProblemError(f"unknown traits {sorted(unknown)}; known are {sorted(TRAITS)}")
        if not (self.has_constraints or self.seen_as):
            traits |= {"unconstrained"}
        return traits | {"vanishing-milstein-term"} if "additive-noise" in traits else traits

    @property
    def pathwise(self) -> Pathwise | None:
        """The truth on a given Brownian path, if one is attached."""
        return next((truth for truth in self.truths if isinstance(truth, Pathwise)), None)

    def view(self, form: "type[Problem]") -> "Problem | None":
        """Return this problem as one of another form, or None where it has no such view."""
        return self if isinstance(self, form) else None

    def ito(self) -> "Problem | None":
        """Return the Ito equation that all comparable components obey, as an `SDE`, or None where there is none.

        It is what one step of a scheme is compared with; its names are those of `parts`, in their order.
        """
        return None

    def state(self, x: Array) -> Any:
        """Return the state whose components are the rows of x, in the order of `ito`'s names."""
        return x

    @property
    def has_constraints(self) -> bool:
        """Whether `residuals` has anything to return."""
        return False

    def admissible(self, x: Array) -> Array:
        """Return states that keep all constraints near the columns of x, rows in the order of `ito`'s names."""
        return x

    def residuals(self, parts: Parts) -> Mapping[str, Residual]:  # noqa: ARG002 - forms with constraints use it
        """Return the defect of each constraint by name; a problem without constraints has none."""
        return {}


def vector(name: str, values: ArrayLike) -> Array:
    """Return a finite vector as an array, or say what is wrong with it.

    Raises
    ------
    ProblemError
        If `values` is no finite one-dimensional array.
    """
    array = numbers(values)
    if array is None or array.ndim != 1 or not array.size or not np.isfinite(array).all():
        raise ProblemError(f"{name} must be a vector of finite numbers, got {shown(values)}")
    array.flags.writeable = False
    return array


def shown(values: object) -> str:
    """Return the representation of a value in one line."""
    return " ".join(repr(values).split())


def numbers(values: ArrayLike) -> Array | None:
    """Return an author's numbers as a new array of floats, or None if they are no real numbers."""
    try:
        return np.array(values).astype(float, casting="safe")
    except (TypeError, ValueError):
        return None


def columns(x: Array, paths: int = PROBES) -> Array:
    """Repeat a vector (n,) as the columns of an array (n, P)."""
    return np.repeat(x[:, None], paths, axis=1)


def check_shape(name: str, value: object, expected: tuple[int, ...]) -> None:
    """Check what an author's function returned on `PROBES` paths.

    The last axis may be 1 where the value is the same on every path.

    Raises
    ------
    ProblemError
        If the value is no finite array of real numbers of the expected shape.
    """
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu":
        given = f"an array of {value.dtype}" if isinstance(value, np.ndarray) else type(value).__name__
        raise ProblemError(f"{name} returned {given}, expected an array of real numbers, shape {expected}")
    if value.shape not in {expected, (*expected[:-1], 1)}:
        text = f"{name} returned shape {value.shape}, expected {expected}"
        raise ProblemError(f"{text} for {expected[-1]} paths (paths last)")
    if not np.isfinite(value).all():
        raise ProblemError(f"{name} is not finite at the initial state: {value[..., 0].tolist()}")


def check_derivative(
    name: str, f: Callable[[Array], Array], derivative: Callable[[Array, Array], Array], x: Array
) -> None:
    """Check an author's derivative (x, y) -> Df(x) y against differences at x and at a point nearby.

    At the initial state alone, a wrong derivative may be right by chance.

    Raises
    ------
    ProblemError
        If they disagree where both are finite.
    """
    y = np.broadcast_to(np.cos(np.arange(1.0, len(x) + 1))[:, None], x.shape)
    for point in (x, x + 0.1 * y):
        given = derivative(point, y)
        if np.isfinite(f(point)).all() and not matches_differences(f, given, point, y):
            raise ProblemError(f"{name} disagrees with a difference quotient at {point[:, 0].tolist()}")


def check_observables(problem: Problem, initial: Parts) -> None:
    """Check that a problem's observables are numbers a path, of components that it has.

    Parameters
    ----------
    problem : Problem
    initial : mapping of str to ndarray, shape (n, P)
        Named components of the initial state on `PROBES` paths.

    Raises
    ------
    ProblemError
        If one asks for another component, or returns another shape. Views may lack components.
    """
    for name, observable in ({} if problem.seen_as else problem.observables).items():
        try:
            value = np.asarray(observable(0.0, initial))
        except KeyError as error:
            known = ", ".join(initial)
            raise ProblemError(
                f"observable {name!r} asks for {error}; the problem's components are {known}"
            ) from error
        if value.shape != (PROBES,):
            text = f"observable {name!r} returned shape {value.shape}, expected ({PROBES},)"
            raise ProblemError(f"{text} for {PROBES} paths")


def check_truth(problem: Problem, initial: Parts) -> None:
    """Check that a problem's pathwise truth starts where the problem does.

    Parameters
    ----------
    problem : Problem
    initial : mapping of str to ndarray, shape (n, P)
        Named components of the initial state on `PROBES` paths.

    Raises
    ------
    ProblemError
        If the truth knows none of the components, or one of another shape or with another initial value.
    """
    if problem.pathwise is None:
        return
    known = problem.pathwise.parts(0.0, problem.pathwise.start(PROBES))
    if not known.keys() & initial.keys():
        raise ProblemError(f"the truth knows {sorted(known)}, the problem's components are {sorted(initial)}")
    for name in known.keys() & initial.keys():
        if np.shape(known[name]) != initial[name].shape:
            given = f"shape {np.shape(known[name])}, expected {initial[name].shape}"
            raise ProblemError(f"the truth gives {name} in {given} (paths last)")
        if not np.allclose(known[name], initial[name], rtol=1e-9, atol=1e-12):
            start = f"{known[name][:, 0].tolist()}, the problem at {initial[name][:, 0].tolist()}"
            raise ProblemError(f"the truth starts with {name} at {start}")
