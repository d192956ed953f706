"""Digits that mean something: how far rounding goes, and what it leaves as it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facade import EPS, LAST_BITS, keep_defined, significant

FINITE = st.floats(1e-290, 1e290) | st.floats(-1e290, -1e-290)


@given(value=FINITE, bits=st.integers(2, 53))
def test_so_many_bits_are_kept(value, bits):
    """A value is off by half of its last bit at most, and a rounded one is not changed again."""
    rounded = float(significant(np.array(value), bits))

    assert abs(rounded - value) <= 2.0**-bits * abs(value)
    assert significant(np.array(rounded), bits) == rounded
    assert float(np.frexp(rounded)[0] * 2.0**bits).is_integer()


def test_single_precision_with_the_exponents_of_double():
    """Rounding is that of single precision, without its overflow and underflow."""
    values = np.array([1.0 / 3.0, -2.0 / 3.0, 1e-40, 1e40])

    assert np.array_equal(significant(values[:2], 24), values[:2].astype(np.float32))
    assert significant(values, 24)[2:] == pytest.approx(values[2:], rel=2.0**-24)


def test_what_is_no_number_stays():
    """Infinities, NaN and zeros are what they were."""
    values = np.array([np.inf, -np.inf, np.nan, 0.0])

    assert np.array_equal(significant(values, 4), values, equal_nan=True)
    assert np.array_equal(keep_defined(values, np.ones(4)), values, equal_nan=True)


@given(value=st.floats(-10.0, 10.0), scale=st.floats(1e-200, 1e200))
def test_differences_are_known_to_the_last_bits_of_their_terms(value, scale):
    """A difference of terms of a size is off by half of four of their last bits at most."""
    rounded = float(keep_defined(np.array(value * scale), np.array(scale)))

    assert abs(rounded - value * scale) <= 0.5 * LAST_BITS * EPS * scale
    assert keep_defined(np.array(rounded), np.array(scale)) == rounded


def test_a_scale_that_is_none():
    """Where nothing is known of the size of terms, differences stay as they are."""
    assert np.array_equal(keep_defined(np.full(3, 1 / 3), np.array([0.0, np.nan, np.inf])), np.full(3, 1 / 3))
