"""Estimates shared by several experiments: means and orders with standard errors."""

from collections.abc import Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import Array
from sdaeverify_lab.papers import Curve, ExperimentEvidence, TableEntry

# Quantile of the normal law for intervals of 90 percent, as in the paper on fibres.
NINETY = 1.6448536269514722


class Mean(NamedTuple):
    """A mean over paths, or a function of means.

    Attributes
    ----------
    value, std_error : ndarray, shape (...), or float
    paths : int
    """

    value: Array
    std_error: Array
    paths: int

    def entry(self, group: str, at: Mapping[str, object], **known: Any) -> TableEntry:
        """Return the row of a table.

        Parameters
        ----------
        group : str
        at : mapping of str to object
        **known : object
            Further fields of `TableEntry`, such as values for comparison.
        """
        return TableEntry(group, at, float(self.value), float(self.std_error), self.paths, **known)

    def curve(self, label: str, x: Array, hue: int | None = None) -> Curve:
        """Return the curve against x, with intervals of 90 percent."""
        return Curve(label, x, self.value, self.low, self.high, hue=hue)

    @property
    def low(self) -> Array:
        """Lower end of the interval of 90 percent."""
        return self.value - NINETY * self.std_error

    @property
    def high(self) -> Array:
        """Upper end of the interval of 90 percent."""
        return self.value + NINETY * self.std_error


def mean(values: Array) -> Mean:
    """Return the mean over the last axis with its standard error."""
    paths = values.shape[-1]
    return Mean(values.mean(axis=-1), values.std(axis=-1, ddof=1) / np.sqrt(paths), paths)


def stack(means: Sequence[Mean]) -> Mean:
    """Stack means of the same paths along a new first axis."""
    return Mean(
        np.array([each.value for each in means]), np.array([each.std_error for each in means]), means[0].paths
    )


def mean_count(evidence: ExperimentEvidence, key: Hashable, counter: str = "newton_iterations") -> Mean:
    """Return the mean cost of a run over steps and paths, with its error from blocks; NaN without results."""
    found = evidence.run(key)
    if found.error or not found.paths:
        return Mean(np.nan, np.nan, 0)
    total, count = found.costs[counter].T
    blocks = total / count
    std_error = blocks.std(ddof=1) / np.sqrt(len(blocks)) if len(blocks) > 1 else 0.0
    return Mean(total.sum() / count.sum(), std_error, found.paths)


def order(h: Array, errors: Array, reference: float = 0.0) -> Mean:
    """Return the order p of mean errors E e = C (h^p - h_ref^p), with its standard error for common paths.

    The slope of log E e against log (h^p - h_ref^p) is 1 at the right p, which removes the error of a reference with
    the step size h_ref > 0. Errors that decrease more slowly than log (h/h_ref) are not of this form, and p tends to
    0.

    Parameters
    ----------
    h : ndarray, shape (L,)
    errors : ndarray, shape (L, P)
    reference : float
        Step size h_ref of the reference; 0 for a truth.
    """
    means, p = errors.mean(axis=1), 1.0
    for _ in range(20):
        x = np.log(h**p - reference**p) / p if reference else np.log(h)
        centred = x - x.mean()
        weights = centred / (centred @ centred)
        p = float(weights @ np.log(means))
    influence = (weights[:, None] * errors / means[:, None]).sum(axis=0)
    paths = errors.shape[1]
    return Mean(p, float(influence.std(ddof=1) / np.sqrt(paths)), paths)


def slope(x: Array, y: Array) -> float:
    """Return the slope of log y against log x."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
