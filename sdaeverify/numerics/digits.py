"""Rounding to significant digits: bits that rounding errors determine are set to zero, which saves storage."""

import numpy as np

from ..arrays import Array

# Significant bits of sums over paths. The rounding differs between groups of paths, like their noise, and is a
# thousand times smaller with a million paths: jackknife intervals contain it.
SAMPLED = 20
# Bits of the largest errors, whose tail index is known to a tenth, and of the size of terms that cancel.
TAIL, SCALE = 12, 6
# Differences of terms are distinguishable from rounding from some hundred times the last bit of the terms on.
LAST_BITS = 4.0
# Powers of two: up to the first, a size is of order one; the second is the largest unit.
ORDINARY, LARGEST = 4, 128


def significant(values: Array, bits: int) -> Array:
    """Return values rounded to `bits` significant bits.

    Parameters
    ----------
    values : ndarray
        Infinite values and NaN are unchanged.
    bits : int
    """
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.round(np.ldexp(mantissa, bits)), exponent - bits))


def unit_of(size: Array | float) -> Array:
    """Return the unit of each size: 1 if it is of order one, 0 or not finite, else the nearest power of two."""
    sound = np.isfinite(size) & (np.asarray(size) > 0.0)
    power = np.clip(np.round(np.log2(np.where(sound, size, 1.0))), -LARGEST, LARGEST)
    return np.where(np.abs(power) <= ORDINARY, 1.0, np.exp2(power))


def keep_defined(values: Array, scale: Array) -> Array:
    """Return differences of terms of size `scale`, rounded to multiples of four last bits of the scale.

    Parameters
    ----------
    values, scale : ndarray
        Broadcast against each other; values are unchanged where the scale is zero or not finite.
    """
    sound = np.isfinite(scale) & (scale > 0.0)
    unit = LAST_BITS * np.spacing(np.exp2(np.floor(np.log2(np.where(sound, scale, 1.0)))))
    return np.where(sound & np.isfinite(values), np.round(values / unit) * unit, values)
