"""The contract of a sealed solver: a problem, a step size, a final time, paths and a seed in, a law out."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Parts, Problem, Scheme, SchemeError, Step

# Steps to the horizon of a solver that names no others.
STEPS = (4, 8, 16)


class Ends(NamedTuple):
    """Final states of a run with the Brownian motions that led to them.

    Attributes
    ----------
    state : ndarray, shape (d, P), or mapping of str to ndarray, shape (n, P)
    W : ndarray, shape (l, P)
        W(T), of which W(0) = 0.
    """

    state: Array | Parts
    W: Array


class Means(NamedTuple):
    """Means of observables over a run, for a solver that returns no states.

    Attributes
    ----------
    values : mapping of str to float
        By the name of the observable.
    errors : mapping of str to float
        Standard errors as the solver estimates them; an observable may be left out. Verdicts do not rest on them:
        they are compared with the spread of means between runs of other seeds.
    """

    values: Mapping[str, float]
    errors: Mapping[str, float] = {}


Returned = Array | Parts | Ends | Means


@dataclass(frozen=True)
class Sealed(Scheme):
    """Base of sealed solvers: a subclass sets name, form and claims as a scheme does, and writes `run`.

    Its claims are about ``weak``, the errors of observables at the horizon, and ``invariant``, those of stationary
    means. The value of either is an order in h, or ``unbiased`` with a bound that holds at every step size.

    Attributes
    ----------
    steps : tuple of int
        Numbers of steps to the horizon at which the claims are made, coarsest first.
    problems : tuple of str
        Labels of the problems that it solves; all of its form if empty.
    independent : bool
        Whether the paths of a run are claimed to be independent of each other. Runs with different seeds always are.
    """

    form: ClassVar[type[Problem] | tuple[type[Problem], ...]] = SDE
    steps: ClassVar[tuple[int, ...]] = STEPS
    problems: ClassVar[tuple[str, ...]] = ()
    independent: ClassVar[bool] = True

    @abstractmethod
    def run(self, problem: Any, h: float, T: float, paths: int, seed: int) -> Returned:
        """Solve a problem from its initial state at time 0 up to T.

        Parameters
        ----------
        problem : Problem
            In the solver's form.
        h : float
            Step size. T/h is a whole number.
        T : float
            Final time, which need not be the problem's horizon.
        paths : int
            Number P of paths.
        seed : int
            Between 1 and 2^31 - 1.

        Returns
        -------
        ndarray, shape (d, P), or mapping of str to ndarray, or Ends, or Means
            Final states, paths last, as one array in the problem's order or by component; or means of observables.
        """

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Refuse to make a single step.

        Raises
        ------
        SchemeError
            Always.
        """
        raise SchemeError(f"{self.name} is a sealed solver, which has no method for a single step")


class _Function(Sealed):
    """A sealed solver made of a function. It is pickled by the name of the function, in whose place it stands."""

    function: ClassVar[Callable[..., Returned]]

    def run(self, problem: Any, h: float, T: float, paths: int, seed: int) -> Returned:
        """Call the function."""
        return type(self).function(problem, h, T, paths, seed)

    def __reduce__(self) -> str:
        return type(self).function.__qualname__


def sealed(
    name: str, claims: tuple[Claim, ...] = (), form: type[Problem] = SDE, **declared: Any
) -> Callable[[Callable[..., Returned]], Sealed]:
    """Return a decorator that makes a function ``(problem, h, T, paths, seed)`` a sealed solver.

    Parameters
    ----------
    name : str
        Of the solver, in lower case with hyphens.
    claims : tuple of Claim
    form : type
        The form that it solves.
    **declared
        Further class variables of `Sealed`, such as ``steps`` and ``problems``.
    """

    def decorate(function: Callable[..., Returned]) -> Sealed:
        fields = {"name": name, "claims": claims, "form": form, **declared, "function": staticmethod(function)}
        about = {"__doc__": function.__doc__, "__module__": function.__module__}
        kind: type[Sealed] = type(function.__name__, (_Function,), {**fields, **about})
        return kind()

    return decorate


def checked(solver: Sealed, view: Problem, found: Any, paths: int) -> Ends | Means:
    """Return the result of a run, with states by component, after a check of its shape.

    Parameters
    ----------
    solver : Sealed
        Named in errors.
    view : Problem
        In the solver's form.
    found : object
        That `Sealed.run` returned.
    paths : int
        Requested number P of paths.

    Raises
    ------
    SchemeError
        If it is none of what may be returned, or its states have another number of rows or paths than they should.
    """
    if isinstance(found, Means):
        return found
    state, W = (found.state, np.asarray(found.W)) if isinstance(found, Ends) else (found, np.zeros((0, paths)))
    parts = dict(state) if isinstance(state, Mapping) else _parts(solver, view, state, paths)
    shapes = {**{name: np.shape(part) for name, part in parts.items()}, "W": W.shape}
    for name, shape in shapes.items():
        if len(shape) != 2 or shape[-1] != paths:
            raise SchemeError(f"{solver.name} returned {name} of shape {shape}, expected (rows, {paths})")
    return Ends({name: np.asarray(part, dtype=float) for name, part in parts.items()}, W)


def _parts(solver: Sealed, view: Problem, state: Any, paths: int) -> Parts:
    try:
        known = np.asarray(state, dtype=float)
    except (TypeError, ValueError):
        kinds = "an array of final states, a mapping of components, Ends or Means"
        raise SchemeError(f"{solver.name} returned {type(state).__name__}, expected {kinds}") from None
    if known.shape != (rows_of(view), paths):
        raise SchemeError(
            f"{solver.name} returned states of shape {known.shape}, expected ({rows_of(view)}, {paths})"
        )
    return solver.parts(view, known)


def rows_of(view: Any) -> int:
    """Return the number d of rows of a state."""
    return sum(map(len, view.parts(view.initial(1)).values()))
