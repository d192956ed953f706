"""Samples of synthetic errors whose slope is known, in the form in which blocks of paths give them."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from facade import POOLED, UNIT, CalibrationCase, Sample
from sdaeverify.measuring import Tally, group_sums

H = 1.0 / 2.0 ** np.arange(3, 9)
CASE = CalibrationCase(scheme="some-scheme", problem="some-problem", order=1.0, weak=("x",))

Make = Callable[..., Sample]


@pytest.fixture(scope="session")
def synthetic() -> Make:
    """Return samples of errors h |Z| with normal Z that are correlated between levels, and of values 1 + h + h Z."""

    @cache
    def make(sequences: int = 120) -> Sample:
        rng = np.random.default_rng(1)
        shape = (sequences * POOLED, len(H), UNIT)
        Z = 0.8 * rng.standard_normal((sequences * POOLED, 1, UNIT)) + 0.6 * rng.standard_normal(shape)
        powers = np.abs(H[:, None] * Z)[..., None, :] ** np.array([0.5, 1.0, 2.0])[:, None]
        counts = np.full((len(Z), 20), UNIT / 20)
        values = 1.0 + H[:, None] + 0.1 * H[:, None] * Z
        strong = Tally(sums={"error x@T": np.moveaxis(group_sums(powers), 0, 1), "paths": counts})
        weak = Tally(sums={"values x": np.moveaxis(group_sums(values), 0, 1), "paths": counts})
        return Sample(CASE, H, strong, weak, None)

    return make
