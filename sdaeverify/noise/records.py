"""Noise beside Brownian motions, declared by the problem that it drives: what is drawn, and how it is refined."""

from typing import Any, Protocol

import numpy as np

from ..arrays import Array


class NoiseRecord(Protocol):
    """Noise that is independent of the Brownian motions, drawn over a coarsest step and refined by halving.

    Its data over n successive steps of one length are an array of shape (n, ..., P) or a NamedTuple of such arrays,
    whose first axis is left out for a single step. The halves of a step are drawn given that step: a finer level
    leaves every coarser one as it was.
    """

    @property
    def name(self) -> str:
        """Name under which increments hold it, and by which schemes declare that they use it."""

    def begin(self, rng: np.random.Generator, h: float, paths: int) -> Any:
        """Return the data of one step of length h, drawn from a stream of its own; the first axis has length 1.

        Parameters
        ----------
        rng : Generator
            Of this record alone.
        h : float
            Length of the step.
        paths : int
            Number P of paths.
        """

    def refined(self, coarse: Any, h: float, rng: np.random.Generator) -> Any:
        """Return the data of the halves of n steps of length h, one after the other: 2 n steps.

        Parameters
        ----------
        coarse : object
            The data of n steps.
        h : float
            Their length.
        rng : Generator
        """

    def joined(self, first: Any, second: Any) -> Any:
        """Return the data of the single step that two equally long ones make up: the inverse of `refined`."""

    def rule(self, h: float) -> tuple[Any, Array]:
        """Return the data of a single step of length h at K nodes in place of paths, and their probabilities (K,)."""
