"""Roots between two positive numbers of any size, found in their logarithms."""

from collections.abc import Callable

import numpy as np
import scipy


def log_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function changes its sign, to rounding.

    Parameters
    ----------
    function : callable, float -> float
        Of opposite signs at the ends, or 0. It is asked at the ends themselves: e^(log x) need not be x, and where a
        root or a jump is there, its sign beside it may be another.
    low, high : float
        Positive.

    Returns
    -------
    float
    """
    first, last = float(np.log(low)), float(np.log(high))
    ends = {first: low, last: high}
    root = scipy.optimize.brentq(
        lambda s: function(ends.get(s, float(np.exp(s)))), first, last, xtol=1e-15, rtol=1e-15
    )
    return ends[root] if root in ends else float(np.exp(root))
