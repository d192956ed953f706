"""Checks of the data that authors of problems provide, made when a problem is built; each error is one clear line."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array, Parts
from ..errors import ProblemError
from ..numerics.derivatives import is_analytic, lengths, matches_differences
from ..numerics.linalg import apply
from .problem import Problem

PROBES = 3
# Rounding alone leaves a few eps; a start further off the manifold is a mistake of the author.
CONSISTENCY = 1e4 * np.finfo(float).eps


def vector(name: str, values: ArrayLike) -> Array:
    """Convert values to a read-only vector of finite numbers.

    Raises
    ------
    ProblemError
        If `values` is not a finite one-dimensional array.
    """
    array = numbers(values)
    if array is None or array.ndim != 1 or not array.size or not np.isfinite(array).all():
        raise ProblemError(f"{name} must be a vector of finite numbers, got {format_value(values)}")
    array.flags.writeable = False
    return array


def format_value(values: object) -> str:
    """Return the representation of a value in one line."""
    return " ".join(repr(values).split())


def numbers(values: ArrayLike) -> Array | None:
    """Return values as a new array of floats, or None if they are not real numbers."""
    try:
        return np.array(values).astype(float, casting="safe")
    except (TypeError, ValueError):
        return None


def largest_component(values: Array) -> str:
    """Return a text with the largest component of a vector (n,) in magnitude and its index; NaN is largest."""
    worst = int(np.argmax(np.where(np.isnan(values), np.inf, np.abs(values))))
    return f"{values[worst]:.3g} in component {worst + 1} of {len(values)}"


def check_not_negative(problem: Problem, *names: str) -> None:
    """Raise unless the named attributes of a problem are finite and not negative.

    Raises
    ------
    ProblemError
        If an attribute is negative or not finite.
    """
    for name in names:
        if not 0.0 <= (value := getattr(problem, name)) < np.inf:
            raise ProblemError(f"{name} must be finite and not negative, got {value!r}")


def check_analytic(name: str, f: Callable[[Array], Array], x: Array, instead: str) -> None:
    """Raise unless a function can be differentiated by a complex step at x.

    Parameters
    ----------
    name : str
        Name of the function in the message.
    f : callable, x -> ndarray
    x : ndarray, shape (d, P)
    instead : str
        End of the message: the alternative for the author.

    Raises
    ------
    ProblemError
        If a complex step does not reproduce the derivative.
    """
    if not is_analytic(f, x):
        raise ProblemError(f"{name} is not analytic (abs or a real array?){instead}")


def check_vanishes(text: str, name: str, value: Array, scale: ArrayLike) -> None:
    """Raise unless a constraint holds at the start up to rounding.

    Parameters
    ----------
    text, name : str
        Beginning of the message, and the name of the constraint in it.
    value : ndarray, shape (m, P)
    scale : ndarray, shape (P,)
        Size of the terms that cancel in the constraint.

    Raises
    ------
    ProblemError
        If it does not hold.
    """
    if np.abs(value).max() > CONSISTENCY * max(1.0, np.max(scale)):
        raise ProblemError(f"{text} {name} = 0: {name} is {largest_component(value[:, 0])}")


def columns(x: Array, paths: int = PROBES) -> Array:
    """Repeat a vector (n,) as the columns of an array (n, P)."""
    return np.repeat(x[:, None], paths, axis=1)


def check_shape(name: str, value: object, expected: tuple[int, ...]) -> None:
    """Check the return value of an author's function on `PROBES` paths.

    The last axis may be 1 if the value is the same on every path.

    Parameters
    ----------
    name : str
        Name of the value in the message: the function as its author wrote it.
    value : object
    expected : tuple of int
        Its shape, paths last.

    Raises
    ------
    ProblemError
        If the value is not a finite array of real numbers of the expected shape.
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
    """Check an author's derivative (x, y) -> Df(x) y against differences at x and at a nearby point.

    At the initial state alone, a wrong derivative may be correct by chance.

    Parameters
    ----------
    name : str
        Name of the derivative in the message.
    f : callable, x -> array of shape (m, P)
    derivative : callable, (x, y) -> array of shape (m, P)
    x : ndarray, shape (d, P)
        The initial state, the same on every path.

    Raises
    ------
    ProblemError
        If they disagree where both are finite.
    """
    y = np.broadcast_to(np.cos(np.arange(1.0, len(x) + 1))[:, None], x.shape)
    # In other units, f may be outside its range of validity at a distance of 1.
    with np.errstate(all="ignore"):
        first, *others = (next(_disagreeing(f, derivative, x, length * y), None) for length in lengths(x))
    if first is not None and all(point is not None for point in others):
        raise ProblemError(f"{name} disagrees with a difference quotient at {first[:, 0].tolist()}")


def _disagreeing(
    f: Callable[[Array], Array], derivative: Callable[[Array, Array], Array], x: Array, y: Array
) -> Iterator[Array]:
    """Yield the points, among x and one nearby, at which a derivative along y disagrees with differences."""
    for point in (x, x + 0.1 * y):
        given = derivative(point, y)
        if np.isfinite(f(point)).all() and not matches_differences(f, given, point, y):
            yield point


def check_product(problem: Any, *state: Array) -> None:
    """Check an author's product B w against the matrix B, at time 0 and the states of `PROBES` paths.

    Raises
    ------
    ProblemError
        If it returns another shape or other numbers.
    """
    if problem.diffusion_product is None:
        return
    w = np.cos(np.arange(1.0, problem.noise_dim + 1))[:, None] * np.ones(PROBES)
    expected = np.broadcast_to(apply(problem.diffusion(0.0, *state), w), state[0].shape)
    given = problem.diffusion_product(0.0, *state, w)
    check_shape("diffusion_product", given, expected.shape)
    if not np.allclose(given, expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max()):
        raise ProblemError("diffusion_product disagrees with the product of diffusion and w at the initial state")


def wave(shape: tuple[int, ...]) -> Array:
    """Return deterministic numbers between -1 and 1 without symmetry, for test vectors."""
    numbers: Array = np.cos(1.0 + np.arange(np.prod(shape)))
    return numbers.reshape(shape)


def check_known(problem: Problem, initial: Parts) -> None:
    """Check a problem's observables, and that its pathwise truth starts at the initial state.

    Parameters
    ----------
    problem : Problem
    initial : mapping of str to ndarray, shape (n, P)
        Named components of the initial state on `PROBES` paths.

    Raises
    ------
    ProblemError
        If an observable uses an unknown component, returns another shape, or is not finite; observables of views are
        not checked, because views may lack components. Or if the truth has no component in common with the problem,
        or a component with another shape or another initial value.
    """
    _check_observables(problem, initial)
    _check_truth(problem, initial)


def _check_observables(problem: Problem, initial: Parts) -> None:
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
        if not np.isfinite(value).all():
            raise ProblemError(f"observable {name!r} is {value[0]} at the initial state")


def _check_truth(problem: Problem, initial: Parts) -> None:
    if problem.pathwise is None:
        return
    known = problem.pathwise.parts(0.0, problem.pathwise.start(PROBES))
    if not known.keys() & initial.keys():
        raise ProblemError(f"the truth provides {sorted(known)}, the problem's components are {sorted(initial)}")
    for name in known.keys() & initial.keys():
        if np.shape(known[name]) != initial[name].shape:
            given = f"shape {np.shape(known[name])}, expected {initial[name].shape}"
            raise ProblemError(f"the truth gives {name} in {given} (paths last)")
        if not np.allclose(known[name], initial[name], rtol=1e-9, atol=1e-12):
            start = f"{known[name][:, 0].tolist()}, the problem at {initial[name][:, 0].tolist()}"
            raise ProblemError(f"the truth starts with {name} at {start}")
