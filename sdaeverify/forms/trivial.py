"""Problems of a form with closed-form solutions that every scheme should reproduce.

Each is offered in a few variants, from full noise to a single column and to an equation with an invariant, because
schemes refuse equations that they are not made for.
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
# More components, constraints and Brownian motions than formulas for small matrices are written for.
WIDE = 6
WIDE_NOISE = np.cos(1.0 + np.arange(float(WIDE * WIDE)) ** 1.5).reshape(WIDE, WIDE)
WIDE_NORMALS = 0.6 * np.cos(2.0 + np.arange(3.0 * WIDE) ** 1.5).reshape(3, WIDE)
WIDE_RATE = np.array([0.6, -0.4, 0.5, 0.3, -0.2, 0.7])
WIDE_START = np.array([0.3, -0.2, 0.5, 0.1, -0.4, 0.6])
RATE = WIDE_RATE[:2]
SPEED = 0.5
# Step size of the checks, and the factor by which it is shortened to examine an error.
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
        The known components at time t, given the sum of all increments of W and, by name, the sums of the
        data of each `NoiseRecord` of the problem; empty if these are omitted.
    finer : Trivial or None
        The problem to use with shorter steps: its delay is the same number of them.
    shorter : float
        Factor by which steps are shortened.
    """

    name: str
    problem: Any
    solution: Callable[..., Parts]
    finer: "Trivial | None" = None
    shorter: float = SHORTER

    @property
    def short_run(self) -> tuple["Trivial", float]:
        """The problem for shorter steps, and their size."""
        return self.finer or self, H * self.shorter

    @property
    def noisy(self) -> bool:
        """Whether the solution depends on W."""
        W = np.zeros((self.problem.noise_dim, 2))
        W[:, 1] = 1.0
        return any(bool(np.ptp(part, axis=1).any()) for part in self.solution(0.0, W).values())


# Each problem with its variants.
Trivials = tuple[tuple[Trivial, ...], ...]
