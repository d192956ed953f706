"""Numbers with the digits that mean something: the others are zero, and take no room where numbers are kept."""

import numpy as np

from ..arrays import Array

# Of sums over paths. What is rounded off is another in each group of paths, as their noise is, and a thousand times
# smaller with a million paths: jackknife intervals contain it.
SAMPLED = 20
# Of the largest errors, whose tail index is known to a tenth, and of the size of terms that cancel.
TAIL, SCALE = 12, 6
# Differences of terms are told from rounding from some hundred times their last bit on.
LAST_BITS = 4.0
# Power of two up to which a size is of order one, and the largest of a unit.
ORDINARY, LARGEST = 4, 128


def significant(values: Array, bits: int) -> Array:
    """Return values rounded to so many significant bits.

    Parameters
    ----------
    values : ndarray
        Infinite ones and NaN stay as they are.
    bits : int
    """
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.round(np.ldexp(mantissa, bits)), exponent - bits))


def unit_of(size: Array | float) -> Array:
    """Return the unit of each size: 1 where it is of order one, 0 or not finite, else the nearest power of two."""
    sound = np.isfinite(size) & (np.asarray(size) > 0.0)
    power = np.clip(np.round(np.log2(np.where(sound, size, 1.0))), -LARGEST, LARGEST)
    return np.where(np.abs(power) <= ORDINARY, 1.0, np.exp2(power))


def keep_defined(values: Array, scale: Array) -> Array:
    """Return differences of terms of a size rounded to multiples of four of their last bits: more is not known.

    Parameters
    ----------
    values, scale : ndarray
        Of shapes that go together; where the scale is zero or not finite, values stay as they are.
    """
    sound = np.isfinite(scale) & (scale > 0.0)
    unit = LAST_BITS * np.spacing(np.exp2(np.floor(np.log2(np.where(sound, scale, 1.0)))))
    return np.where(sound & np.isfinite(values), np.round(values / unit) * unit, values)
