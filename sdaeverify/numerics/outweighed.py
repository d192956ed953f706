"""One test of sizes: whether the size of an expectation exceeds the sum of the sizes of others."""

from itertools import product

import numpy as np
import scipy

from ..arrays import Array


def outweighs(a: Array, *others: Array) -> Array:
    """Return the p-value of the hypothesis |E a| <= sum_j |E b_j|.

    |E a| > sum_j |E b_j| means that s E a + sum_j s_j E b_j is positive for a sign s and all signs s_j: the largest
    p-value of these t-tests, and twice that because s is taken from the sample.

    Parameters
    ----------
    a : ndarray, shape (K, ...)
        Group means.
    *others : ndarray, shape (K, ...)
        The b_j, broadcast against a.

    Returns
    -------
    ndarray, shape (...)
    """
    a = np.where(a.mean(axis=0) >= 0.0, 1.0, -1.0) * a
    patterns = product((1.0, -1.0), repeat=len(others))
    sums = (sum((sign * b for sign, b in zip(signs, others, strict=True)), a) for signs in patterns)
    t = np.min([t_values(each) for each in sums], axis=0)
    return np.asarray(np.where(np.isnan(t), 1.0, np.minimum(1.0, 2.0 * scipy.special.stdtr(len(a) - 1, -t))))


def sample_growth(p: float, needed: float, groups: int) -> float:
    """Return by which factor a sample must grow until a p-value falls to what is needed, if its figures stay.

    Parameters
    ----------
    p, needed : float
        Both of two-sided t-tests.
    groups : int
        Number of group means that are tested.
    """
    now, then = (float(scipy.special.stdtrit(groups - 1, 1.0 - 0.5 * value)) for value in (p, needed))
    # From less than one standard error nothing can be foretold.
    return max(1.0, (then / now) ** 2) if now > 1.0 else np.inf


def t_values(values: Array) -> Array:
    """Return means of groups (K, ...) in units of their standard errors; 0 where all are 0."""
    mean, se = values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(len(values))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(se > 0.0, mean / se, np.where(mean == 0.0, 0.0, np.sign(mean) * np.inf)))
