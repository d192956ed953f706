"""The contract of a solver that chooses its steps: a problem, a path and a tolerance in, the final state out."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Increment, Problem, Scheme, SchemeError, Step

from .path import Path

# Of the tolerances that are tried if a solver names no others.
TOLERANCES = (2.0**-4, 2.0**-6, 2.0**-8, 2.0**-10, 2.0**-12)


class Solved(NamedTuple):
    """What a solver returns.

    Attributes
    ----------
    state : ndarray, shape (d, P)
        At the final time.
    steps, rejected, evaluations : ndarray of int, shape (P,)
        Steps that were accepted and rejected, and how often the coefficients were evaluated.
    times : ndarray of int, shape (n, P), or None
        Ticks at which the solver knew its noise, in any order, a time more than once if it likes.
    W : ndarray, shape (n, l, P), or None
        The Brownian motions that it used there; both are None for a solver that does not tell.
    """

    state: Array
    steps: Array
    rejected: Array
    evaluations: Array
    times: Array | None = None
    W: Array | None = None


@dataclass(frozen=True)
class Adaptive(Scheme):
    """Base of all adaptive solvers: a subclass sets name, form and claims as a scheme does, and writes `solve`.

    Its claims are about ``tolerance``, the rate of the error in the tolerance; ``tolerance-steps``, its order in the
    mean number of steps, rejected ones counted; and ``tolerance-law``, the bias of observables in the end.

    Attributes
    ----------
    tolerances : tuple of float
        The range on which the claims are made, largest first.
    own_noise : bool
        Whether it insists on noise of its own and does not look at the path: its errors along paths mean nothing
        then, and its law alone is judged.
    in_batches : bool
        Whether paths that are solved together share their steps: then a batch is the unit that is sampled.
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
            In the solver's form.
        path : Path
            The noise. It is asked at ticks, as often and in any order.
        tolerance : float
            What the solver's own tolerances are set to.
        """

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Refuse to make a single step.

        Raises
        ------
        SchemeError
            Always.
        """
        raise SchemeError(f"{self.name} chooses its steps: it solves along a path, and makes no single step")


def why_not_own_times(problem: SDE) -> str:
    """Return why the coefficients cannot be had at another time on each path, or an empty string."""
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
