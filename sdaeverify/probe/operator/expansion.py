"""What an error leaves behind as h tends to 0: the coefficients of its lowest powers, by extrapolation.

Of e(h) = c_0 + c_1 h + c_2 h^2 + ..., a small c_0 hardly changes the local orders at the step sizes used; so does a
small c_1 beside c_2. Eliminating the next powers one after the other leaves c_0 (Romberg), and that of e(h)/h^q the
coefficient of h^q where all lower ones vanish. What little is left may belong to half powers: these are tried, too.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array

# A coefficient is told from 0 from so many times what is known of it on.
CLEAR = 10.0
FEWEST = 4


class Coefficient(NamedTuple):
    """The coefficient of the lowest power that does not vanish, or may not.

    Attributes
    ----------
    power : float
        q of c h^q, a whole number.
    value, known : float
        c, and how far it can be off.
    """

    power: float
    value: float
    known: float

    @property
    def clear(self) -> bool:
        """Whether c is told from 0."""
        return abs(self.value) > CLEAR * self.known


def lowest_power(h: Array, errors: Array, floors: Array, below: float) -> Coefficient | None:
    """Return the lowest power below a bound whose coefficient is not explained by what is known of it, or None.

    Parameters
    ----------
    h : ndarray, shape (H,)
        Step sizes, each half of the one before.
    errors, floors : ndarray, shape (H,)
        Errors with their signs, and how far they can be off.
    below : float

    Returns
    -------
    Coefficient or None
    """
    finite = np.isfinite(errors) & np.isfinite(floors)
    h, errors, floors = h[finite], errors[finite], floors[finite]
    if len(h) < FEWEST:
        return None
    found = (_coefficient(errors / h**power, floors / h**power, power) for power in np.arange(0.0, below))
    return next((each for each in found if each is not None), None)


def _coefficient(values: Array, floors: Array, power: float) -> Coefficient | None:
    whole, half = (Coefficient(float(power), *_limit(values, floors, step)) for step in (1.0, 0.5))
    explained = abs(whole.value) <= whole.known or (not whole.clear and abs(half.value) <= half.known)
    return None if explained else whole


def _limit(values: Array, floors: Array, step: float) -> tuple[float, float]:
    """Return the values extrapolated to h = 0, and how far that can be off.

    It is known to how far it changes without the finest step size, the coarsest or the two coarsest: the first
    predicts what the finest adds.
    """
    tables, blur = [values], floors
    for column in range(1, len(values)):
        ratio = 2.0 ** (step * column)
        tables.append((ratio * tables[-1][1:] - tables[-1][:-1]) / (ratio - 1.0))
        blur = (ratio * blur[1:] + blur[:-1]) / (ratio - 1.0)
    (limit,), before = tables[-1], [*tables[-2], tables[-3][-1]]
    return float(limit), float(np.abs(before - limit).max() + blur[0])
