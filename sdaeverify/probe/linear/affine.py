"""Affine functions, determined from their values at 0 and the unit vectors and checked at states of several sizes.

A function that is affine near 0 may be nonlinear at the states of solutions: x - x^3 is affine up to rounding if x
has units of 1e-8, say. So the check includes states that a solution reaches.
"""

import numpy as np

from ...arrays import Array
from ..step.nodes import SEED

# Largest relative defect of an affine function, and of a quadratic one.
# Rounding: values of 64 operations err by 64 eps of |R| |x| + |r| (Higham 2002, Lemma 3.1). A column of R is the
# difference of two values, so that R x errs by 128 eps (|R| |x| + |r| |x|_1), with |x|_1 <= 100 sqrt(k): together
# 2.9e-12 sqrt(k) of the terms if |r| is no larger than |R|, which is 1e-10 for k = 1200.
# Measured by tests/probe/test_affine.py: no shipped step has a defect between 1e-12 and 1e-4.
AFFINE = 1e-10
# Size: of the trial states.
SIZES = (0.1, 1.0, 10.0, 100.0)
TINY = float(np.finfo(float).tiny)


def corners(k: int) -> Array:
    """Return 0 and the unit vectors, shape (k, 1 + k)."""
    return np.concatenate([np.zeros((k, 1)), np.eye(k)], axis=1)


def trial_states(k: int) -> Array:
    """Return the corners and, for the check, random vectors of lengths 0.1, 1, 10 and 100, shape (k, k + 5)."""
    rng = np.random.Generator(np.random.Philox(key=SEED + 2))
    x = rng.standard_normal((k, len(SIZES)))
    return np.concatenate([corners(k), x / np.linalg.norm(x, axis=0) * SIZES], axis=1)


def with_trials(reached: Array) -> Array:
    """Return the trial states followed by states that a solution reaches, shape (k, k + 5 + S) for (k, S)."""
    return np.concatenate([trial_states(len(reached)), reached], axis=1)


def at_corners(values: Array, last: float = 1.0) -> Array:
    """Return [[R, r], [0, last]] of functions R x + r from their values at the corners.

    Parameters
    ----------
    values : ndarray, shape (d, 1 + k, K)
        Values of K functions at the corners.
    last : float, optional

    Returns
    -------
    ndarray, shape (d + 1, k + 1, K)
    """
    d, states, count = values.shape
    whole = np.zeros((d + 1, states, count))
    whole[:d, -1] = values[:, 0]
    whole[:d, :-1] = values[:, 1:] - values[:, :1]
    whole[d, -1] = last
    return whole


def defect(states: Array, values: Array, fitted: Array) -> float:
    """Return the largest |f(x) - (R x + r)| relative to |R| |x| + |r| or |f(x)|, whichever is larger.

    Parameters
    ----------
    states : ndarray, shape (k, n)
        The corners, followed by the states of the check.
    values : ndarray, shape (d, n, K)
        Values of K functions at the states.
    fitted : ndarray, shape (d + 1, k + 1, K)
        [[R, r], [0, .]], as found from the corners.

    Returns
    -------
    float
        Infinite if a value is NaN; infinite values are ignored.
    """
    k = fitted.shape[1] - 1
    x = np.append(states[:, k + 1 :], np.ones((1, states.shape[1] - k - 1)), axis=0).T
    predicted, size = x @ fitted[:-1], np.abs(x) @ np.abs(fitted[:-1])
    given = values[:, k + 1 :]
    return relative(given - predicted, np.maximum(size, np.abs(given)))


def relative(difference: Array, size: Array) -> float:
    """Return the largest ratio of |difference| to size, each maximised over the first axis first."""
    largest, scale = np.abs(difference).max(axis=0), size.max(axis=0)
    ratio = largest / np.maximum(scale, TINY)
    return float(np.max(np.where(np.isnan(ratio), np.inf, ratio), initial=0.0, where=~np.isinf(scale)))
