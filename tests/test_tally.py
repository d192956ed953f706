"""Evidence of two samples merges into evidence of both."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from facade import largest
from sdaeverify.measuring import Tally

WHOLE = arrays(float, 12, elements=st.integers(-1000, 1000).map(float))


def note(values):
    return Tally({"sum": values.sum(keepdims=True)}, {"max": values.max(keepdims=True)}, {"top": largest(values, 3)})


@given(WHOLE, WHOLE)
def test_merging_equals_noting_everything_at_once(a, b):
    """Sums, maxima and largest values of two parts are those of the whole."""
    merged, whole = note(a).merge(note(b)), note(np.concatenate([a, b]))

    assert merged.sums["sum"] == whole.sums["sum"]
    assert merged.maxima["max"] == whole.maxima["max"]
    assert (merged.largest["top"] == whole.largest["top"]).all()


def test_names_of_either_side_are_kept():
    """What only one side noted stays."""
    merged = Tally({"a": np.ones(1)}).merge(Tally({"b": np.ones(1)}))

    assert set(merged.sums) == {"a", "b"}


def test_a_nan_is_never_lost():
    """A path that is not finite stays visible in sums and among the largest, and hides no maximum."""
    bad, good = (
        Tally({"s": np.array([np.nan])}, {"m": np.array([np.nan])}, {"t": np.array([np.nan, 1.0])}),
        note(np.arange(12.0)),
    )

    merged = bad.merge(Tally({"s": np.ones(1)}, {"m": good.maxima["max"]}, {"t": np.array([3.0, 2.0])}))

    assert np.isnan(merged.sums["s"][0])
    assert merged.maxima["m"] == good.maxima["max"]
    assert np.isnan(merged.largest["t"][0])


def test_numbers_lie_as_they_do_in_what_was_read():
    """Rows lie one behind the other however they were made, so that sums are the same to the last bit."""
    turned = np.arange(6.0).reshape(2, 3).T

    tally = Tally({"a": turned}, {"b": np.array(1.0)})

    assert tally.sums["a"].flags.c_contiguous
    assert np.array_equal(tally.sums["a"], turned)
    assert tally.maxima["b"].shape == ()
