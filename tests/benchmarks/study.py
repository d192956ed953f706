"""The strong study that is timed against rivals: Euler-Maruyama on geometric Brownian motion."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

import sdaeverify
from facade import gbm
from sdaeverify import SDE, Array

A, B, X_0 = 0.5, 0.6, 1.0
COARSEST, LEVELS = 8, 6
STEPS = tuple(COARSEST * 2**level for level in range(LEVELS))
GRID = np.arange(1, COARSEST + 1) / COARSEST


class Means(NamedTuple):
    """Mean over paths of the largest error on the coarsest grid, with its standard error; coarsest level first.

    Attributes
    ----------
    value, error : ndarray, shape (L,)
    """

    value: Array
    error: Array

    def agree(self, other: "Means") -> bool:
        """Tell whether no level differs by more than 5 standard errors: by chance, less than 1 in 100 000 times."""
        return bool((abs(self.value - other.value) < 5.0 * np.hypot(self.error, other.error)).all())


def means(errors: Array) -> Means:
    """Return the means of errors of shape (L, P)."""
    return Means(errors.mean(axis=1), errors.std(axis=1, ddof=1) / np.sqrt(errors.shape[1]))


def geometric() -> SDE:
    """Return the problem without its controls, which would run beside the scheme."""
    return replace(gbm(A, B, X_0), controls=())


def ours(paths: int) -> Means:
    """Run the study with sdaeverify, on one core."""
    result = sdaeverify.verify(
        "euler-maruyama",
        [geometric],
        "strong",
        paths=paths,
        coarsest=COARSEST,
        levels=LEVELS,
        max_looks=1,
    )
    table = result.levels.query("quantity == 'x'")
    return Means(table["estimate"].to_numpy(), table["std_error"].to_numpy())
