"""Problems of a form with a solution in closed form that a scheme has no excuse to miss.

Each is offered in a few variants, from full noise to a single column and to an equation with an invariant, because
schemes refuse what they cannot treat.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, Parts

# Two columns, then one: full, diagonal, single.
NOISES: tuple[Array, ...] = (
    np.array([[0.7, -0.3], [0.2, 0.9]]),
    np.diag([0.7, 0.9]),
    np.array([[0.7], [0.2]]),
)
# Gradients of two constraints in R^4, not orthogonal: their Gram matrix is full.
NORMALS = np.array([[0.8, -0.3, 0.4, 0.2], [0.5, 0.7, -0.2, 0.3]])
RATE = np.array([0.6, -0.4])
SPEED = 0.5
# The checks' step size, and the factor by which it is shortened where an error is found.
H, SHORTER = 2.0**-6, 2.0**-20
SOURCE = "trivial problem of the conformance checks"


class Trivial(NamedTuple):
    """A problem and its solution.

    Attributes
    ----------
    name : str
        The equation, for messages.
    problem : Problem
    solution : callable, (float, ndarray of shape (l, P)) -> mapping of str to ndarray
        The components that are known at time t, given the sum of all increments of W, and by name what the data of
        each `NoiseRecord` of the problem add up to; none where these are left out.
    finer : Trivial or None
        What takes its place on shorter steps: a delay of the same number of them.
    shorter : float
        By how much steps are shortened.
    """

    name: str
    problem: Any
    solution: Callable[..., Parts]
    finer: "Trivial | None" = None
    shorter: float = SHORTER

    @property
    def short_run(self) -> tuple["Trivial", float]:
        """The problem on shorter steps, and their size."""
        return self.finer or self, H * self.shorter

    @property
    def noisy(self) -> bool:
        """Whether the solution depends on W."""
        W = np.zeros((self.problem.noise_dim, 2))
        W[:, 1] = 1.0
        return any(bool(np.ptp(part, axis=1).any()) for part in self.solution(0.0, W).values())


# Each problem with its variants.
Trivials = tuple[tuple[Trivial, ...], ...]
