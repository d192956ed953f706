"""Laws of a scheme's increments: Gaussian, or bounded variables that share its first moments.

A bounded variable is coupled to the Brownian increment by its quantiles, so that a scheme that uses it runs on the
same paths as every other. Sums of bounded variables are not bounded variables of a longer step: such schemes have
a weak order only.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .arrays import Array
from .noise import Increment

# P(|N| <= QUANTILE) = 2/3 for a standard normal N.
QUANTILE = 0.967421566101701


class Law(NamedTuple):
    """The law of each component of the increments that a scheme is given.

    Attributes
    ----------
    name : str
    couple : callable, ndarray -> ndarray
        The variable of unit variance as a function of a standard normal.
    values, weights : tuple of float
        Atoms of unit variance and their probabilities; empty for the normal law.
    """

    name: str
    couple: Callable[[Array], Array]
    values: tuple[float, ...] = ()
    weights: tuple[float, ...] = ()

    @property
    def bounded(self) -> bool:
        """Whether it is a bounded variable, which has atoms."""
        return bool(self.values)

    def increment(self, noise: Increment, h: float) -> Increment:
        """Return the increment of a step of size h with this law, coupled to a Brownian one."""
        if not self.bounded:
            return noise
        return Increment(np.sqrt(h) * self.couple(noise.dW / np.sqrt(h)), None)


def _normal(x: Array) -> Array:
    return x


def _three_point(x: Array) -> Array:
    return np.asarray(np.sqrt(3.0) * np.sign(x) * (np.abs(x) > QUANTILE))


def _two_point(x: Array) -> Array:
    return np.where(x < 0.0, -1.0, 1.0)


GAUSSIAN = Law("gaussian", _normal)
THREE_POINT = Law("three-point", _three_point, (-(3.0**0.5), 0.0, 3.0**0.5), (1 / 6, 2 / 3, 1 / 6))
TWO_POINT = Law("two-point", _two_point, (-1.0, 1.0), (0.5, 0.5))
