"""Noise other than Brownian motions, declared by the problem that it drives: how it is drawn and refined."""

from typing import Any, Protocol

import numpy as np

from ..arrays import Array


class NoiseRecord(Protocol):
    """Noise independent of the Brownian motions, drawn over a coarsest step and refined by halving.

    Its data over n successive steps of equal length are an array of shape (n, ..., P) or a NamedTuple of such arrays,
    without the first axis for a single step. The halves of a step are drawn conditionally on that step: a finer level
    leaves every coarser one unchanged.
    """

    @property
    def name(self) -> str:
        """Name of the noise in increments, by which schemes declare that they use it."""

    def begin(self, rng: np.random.Generator, h: float, paths: int) -> Any:
        """Return the data of one step of length h; the first axis has length 1.

        Parameters
        ----------
        rng : Generator
            Random stream of this record only.
        h : float
            Length of the step.
        paths : int
            Number P of paths.
        """

    def refined(self, coarse: Any, h: float, rng: np.random.Generator) -> Any:
        """Return the data of the halves of n steps of length h, in time order: 2 n steps.

        Parameters
        ----------
        coarse : object
            The data of n steps.
        h : float
            Length of these steps.
        rng : Generator
        """

    def joined(self, first: Any, second: Any) -> Any:
        """Return the data of the step made of two successive steps of equal length: the inverse of `refined`."""

    def rule(self, h: float) -> tuple[Any, Array]:
        """Return the data of a step of length h at K nodes in place of paths, and their probabilities, shape (K,)."""
