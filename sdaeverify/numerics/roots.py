"""Root finding on an interval of positive numbers, in the logarithm of the argument."""

from collections.abc import Callable

import numpy as np
import scipy


def log_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the point where a function changes sign, to rounding.

    Parameters
    ----------
    function : callable, float -> float
        Of opposite signs at the ends, or 0. At the ends it is evaluated at `low` and `high` exactly: e^(log x) may
        differ from x, and if there is a root or a jump at an end, the sign next to it may differ.
    low, high : float
        Ends of the interval, positive.

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
