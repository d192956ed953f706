"""Settings refuse what cannot be run, in one line."""

import pytest

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
        ({"block": 1}, "block must be between 40 and 2\\^20"),
    ],
)
def test_values_out_of_range_are_refused(options, words):
    """Each value out of its range is named with what was expected and given."""
    with pytest.raises(UsageError, match=words) as error:
        Settings(**options)

    assert "\n" not in str(error.value)


def test_blocks_cover_all_paths():
    """The last block holds what is left."""
    settings = Settings(paths=5000, block=2048)

    assert [settings.paths_of(block) for block in range(settings.blocks)] == [2048, 2048, 904]
