"""Statistics of many repetitions at once, and true values from repetitions that are independent of them."""

from collections.abc import Callable

import numpy as np

from ...arrays import Array
from ...numerics.statistics import GROUPS, Estimate, pseudo_values

Statistic = Callable[[Array], Array]


def estimates(sums: Array, counts: Array, statistic: Statistic) -> Estimate:
    """Return the jackknife's estimates of R repetitions, with their standard errors.

    Parameters
    ----------
    sums : ndarray, shape (R, G, ...)
        Sums over groups.
    counts : ndarray, shape (G,)
        Paths of each group.
    statistic : callable, ndarray of shape (..., R) -> ndarray, shape (R,)
        Function of the means.

    Returns
    -------
    Estimate
        Of arrays of shape (R,).
    """
    pseudo = pseudo_values(np.moveaxis(sums, 0, -1), counts, statistic)
    return Estimate(pseudo.mean(axis=0), pseudo.std(axis=0, ddof=1) / np.sqrt(GROUPS))


def opposite(values: Array, statistic: Statistic, sequences: int, repetitions: int) -> Array:
    """Return for each repetition the statistic of all those in the half that it is not in.

    Parameters
    ----------
    values : ndarray, shape (U, ...)
        Of repetitions in order, a whole number of them to each sequence; the function of their mean is taken.
    statistic : callable
        See `estimates`.
    sequences : int
        At least two.
    repetitions : int
        For how many the result is; of the same sequences.

    Returns
    -------
    ndarray, shape (repetitions,)
    """
    first = sequences // 2
    middle = len(values) // sequences * first
    truths = [statistic(half.mean(axis=0)) for half in (values[middle:], values[:middle])]
    own = repetitions // sequences * first
    return np.repeat(np.array(truths), [own, repetitions - own])
