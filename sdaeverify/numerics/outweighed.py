"""Test of whether the size of an expectation exceeds the sum of the sizes of other expectations."""

from itertools import product

import numpy as np
import scipy

from ..arrays import Array


def outweighs(a: Array, *others: Array) -> Array:
    """Return the p-value of the hypothesis |E a| <= sum_j |E b_j|.

    |E a| > sum_j |E b_j| means that s E a + sum_j s_j E b_j > 0 for a sign s and all signs s_j. The p-value is the
    largest of these t-tests, doubled because s is chosen from the sample.

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
    """Return the factor by which a sample must grow to reach a p-value, if effect and variance stay the same.

    Parameters
    ----------
    p, needed : float
        Present and required p-value of two-sided t-tests.
    groups : int
        Number of group means in the test.
    """
    now, then = (float(scipy.special.stdtrit(groups - 1, 1.0 - 0.5 * value)) for value in (p, needed))
    # An effect of less than one standard error does not allow a prediction.
    return max(1.0, (then / now) ** 2) if now > 1.0 else np.inf


def t_values(values: Array) -> Array:
    """Return the group means (K, ...) divided by their standard error; 0 if all groups are 0."""
    mean, se = values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(len(values))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(se > 0.0, mean / se, np.where(mean == 0.0, 0.0, np.sign(mean) * np.inf)))
