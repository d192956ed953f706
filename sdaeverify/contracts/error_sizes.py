"""How large the errors of a quantity are at each step size: what is compared between two versions of a scheme."""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..numerics.statistics import pseudo_values


class ErrorSizes(NamedTuple):
    """Sizes of the errors of one quantity at the step sizes where they can be told.

    Attributes
    ----------
    h : ndarray, shape (L,)
        Step sizes, coarsest first.
    log2 : ndarray, shape (L,)
        Logarithms of the sizes.
    replicates : ndarray, shape (G, L), or None
        Pseudo-values of the jackknife over groups of paths; None where nothing is sampled.
    counts : ndarray, shape (G,), or None
        Paths of each group.
    exact : bool
        Whether there is no error beyond rounding at all.
    remark : str
        Why step sizes are left out.
    """

    h: Array
    log2: Array
    replicates: Array | None = None
    counts: Array | None = None
    exact: bool = False
    remark: str = ""


def without_error(remark: str) -> ErrorSizes:
    """Return the sizes of errors that are rounding at every step size."""
    return ErrorSizes(np.zeros(0), np.zeros(0), exact=True, remark=remark)


def estimate_sizes(h: Array, sums: Array, counts: Array, remark: str = "") -> ErrorSizes:
    """Return the sizes of mean errors.

    Parameters
    ----------
    h : ndarray, shape (L,)
    sums : ndarray, shape (G, L)
        Sums of the errors, with their sign if they have one, over groups of paths.
    counts : ndarray, shape (G,)
    remark : str, optional
    """
    replicates = pseudo_values(sums, counts, _log_size)
    return ErrorSizes(h, _log_size(sums.sum(axis=0) / counts.sum()), replicates, counts, remark=remark)


def deterministic(h: Array, sizes: Array, seen: Array, remark: str = "") -> ErrorSizes:
    """Return the sizes of errors that are known without sampling, where they are seen above rounding.

    Parameters
    ----------
    h : ndarray, shape (L,)
    sizes : ndarray, shape (L,)
        Of the error at each step size.
    seen : ndarray of bool, shape (L,)
        Where the error is above rounding: the rest is left out.
    remark : str
        What has to be said beside the numbers.
    """
    return ErrorSizes(h[seen], _log_size(sizes[seen]), remark=remark)


def _log_size(means: Array) -> Array:
    return np.asarray(np.log2(np.abs(means)))
