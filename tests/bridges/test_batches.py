"""Paths in batches of few sizes."""

import numpy as np
import pytest

from sdaeverify_bridges.kit import in_batches


@pytest.mark.parametrize("paths", [1, 3, 1024, 1025, 2500])
def test_any_number_of_paths_is_one_shape(paths):
    """Every path gets its result, and the step meets batches of 1024 paths only."""
    sizes, x = set(), np.arange(2.0 * paths).reshape(2, paths)

    def step(x, w):
        sizes.add(x.shape[-1])
        return x + w

    np.testing.assert_array_equal(in_batches(step, (x, 10.0 * x[:1])), x + 10.0 * x[:1])
    assert sizes == {1024}


def test_filling_is_a_path_like_the_others():
    """What a batch is filled up with is no state that nobody asked for."""
    seen = []

    def step(x):
        seen.append(x)
        return x

    in_batches(step, (np.array([[1.0, 2.0]]),))
    assert set(np.unique(seen[0])) == {1.0, 2.0}
