"""The contract of an adaptive solver: from a problem, a path and a tolerance to the final state."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Increment, Problem, Scheme, SchemeError, Step

from .path import Path

# Default tolerances of a solver.
TOLERANCES = (2.0**-4, 2.0**-6, 2.0**-8, 2.0**-10, 2.0**-12)


class Solved(NamedTuple):
    """Result of a solver.

    Attributes
    ----------
    state : ndarray, shape (d, P)
        State at the final time.
    steps, rejected, evaluations : ndarray of int, shape (P,)
        Numbers of accepted steps, rejected steps and evaluations of the coefficients.
    times : ndarray of int, shape (n, P), or None
        Ticks at which the solver used the path, in any order, possibly with repetitions.
    W : ndarray, shape (n, l, P), or None
        Brownian motions at these ticks; both are None if the solver does not report them.
    """

    state: Array
    steps: Array
    rejected: Array
    evaluations: Array
    times: Array | None = None
    W: Array | None = None


@dataclass(frozen=True)
class Adaptive(Scheme):
    """Base of adaptive solvers: a subclass sets name, form and claims as a scheme does, and defines `solve`.

    Claims are about ``tolerance``, the rate of the error in the tolerance; ``tolerance-steps``, its order in the mean
    number of steps, including rejected ones; and ``tolerance-law``, the bias of observables at the final time.

    Attributes
    ----------
    tolerances : tuple of float
        Range of tolerances of the claims, largest first.
    own_noise : bool
        Whether the solver draws its own noise instead of using the path. Its errors along paths are then meaningless,
        and only its law is judged.
    in_batches : bool
        Whether paths that are solved together share their steps, so that a batch is the unit of the sample.
    """

    form: ClassVar[type[Problem]] = SDE
    tolerances: ClassVar[tuple[float, ...]] = TOLERANCES
    own_noise: ClassVar[bool] = False
    in_batches: ClassVar[bool] = False

    @abstractmethod
    def solve(self, problem: Any, path: Path, tolerance: float) -> Solved:
        """Solve a problem on each path up to its horizon.

        Parameters
        ----------
        problem : Problem
            Problem in the solver's form.
        path : Path
            The noise, which can be evaluated at ticks repeatedly and in any order.
        tolerance : float
            Value to which the solver's tolerances are set.
        """

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Raise, because an adaptive solver makes no single step.

        Raises
        ------
        SchemeError
            Always.
        """
        raise SchemeError(f"{self.name} is an adaptive solver, which has no method for a single step")


def why_not_own_times(problem: SDE) -> str:
    """Return why the coefficients do not accept a different time on each path, or an empty string."""
    t, x = problem.horizon * np.array([0.0, 0.3, 0.7]), problem.initial(3)
    for name in ("drift", "diffusion"):
        coefficient = getattr(problem, name)
        try:
            together = np.asarray(coefficient(t, x)) + 0.0 * t
            alone = np.concatenate([np.asarray(coefficient(s, x[:, i : i + 1])) for i, s in enumerate(t)], axis=-1)
            same = np.allclose(together, alone, rtol=1e-12, atol=0.0)
        except (ValueError, TypeError, IndexError):
            same = False
        if not same:
            return f"the {name} does not take an array of times, one for each path"
    return ""
