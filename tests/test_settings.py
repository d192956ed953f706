"""Settings refuse what cannot be run, in one line."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facade import settings_from
from sdaeverify import Settings, UsageError


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"paths": 10}, "paths must be at least 40, got 10"),
        ({"levels": 2}, "levels must be at least 3"),
        ({"levels": 60}, "finest number of steps must be at most"),
        ({"coarsest": 0}, "coarsest number of steps must be at least 1"),
        ({"seed": -1}, "seed must be between 0"),
        ({"confidence": 1.5}, "confidence must be between 0.5 and 1"),
        ({"max_looks": 0}, "max_looks must be between 1 and 20"),
        ({"tests_reserved": 0}, "tests_reserved must be at least 1"),
        ({"block": 1}, "block must be between 40 and 2\\^20"),
    ],
)
def test_values_out_of_range_are_refused(options, words):
    """Each value out of its range is named with what was expected and given."""
    with pytest.raises(UsageError, match=words) as error:
        Settings(**options)

    assert "\n" not in str(error.value)


def used(settings):
    """Return the paths of each block that are used."""
    return [settings.paths_of(block) for block in range(settings.blocks)]


def test_blocks_cover_all_paths():
    """From the second on blocks double what there is up to their largest size; the last one holds what is left."""
    settings = Settings(paths=7000, block=2048)

    assert settings.sizes == (256, 768, 1024, 2048, 2048, 2048)
    assert used(settings) == [256, 768, 1024, 2048, 2048, 856]


@given(paths=st.integers(40, 20_000), block=st.integers(40, 8192), looks=st.integers(1, 8))
def test_looks_end_with_all_paths_and_at_least_double_them(paths, block, looks):
    """Each look has at least as many new paths as all before it, except that the last one takes what is left."""
    settings = Settings(paths=paths, block=block, max_looks=looks)
    totals = [sum(used(settings)[:end]) for end in settings.ends]

    assert totals[-1] == paths
    assert 1 <= len(totals) <= looks
    assert all(2 * a <= b for a, b in pairwise(totals))


@given(paths=st.integers(40, 20_000), more=st.integers(1, 20_000))
def test_more_paths_keep_the_blocks_there_are(paths, more):
    """The noise of a path does not depend on how many follow it."""
    few, many = Settings(paths=paths), Settings(paths=paths + more)

    assert many.sizes[: few.blocks] == few.sizes


def test_the_level_is_shared_by_looks_and_tests():
    """Bonferroni: the error of a run over the tests of a family and the looks at each."""
    settings = Settings(paths=8192, max_looks=5, tests_reserved=100, confidence=0.99)

    assert settings.level == pytest.approx(0.01 / 500)


@pytest.mark.parametrize(("text", "expected"), [("8..256", (8, 6)), ("128..2048", (128, 5)), ("3..48", (3, 5))])
def test_levels_as_a_range_of_steps(text, expected):
    """Levels are given by the coarsest and the finest number of steps."""
    settings = settings_from(levels=text)

    assert (settings.coarsest, settings.levels) == expected
