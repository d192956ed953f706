"""A file is there as a whole or not at all."""

import pytest

from facade import UNFINISHED, write_whole


def test_a_file_is_replaced_at_the_end(tmp_path):
    """While a file is written, readers find the old one; then the new one, and nothing beside it."""
    place = tmp_path / "file"
    place.write_text("old")

    with write_whole(place) as file:
        file.write(b"new")
        file.flush()
        assert place.read_text() == "old"
        assert [path.name.startswith(UNFINISHED) for path in sorted(tmp_path.iterdir())] == [True, False]

    assert place.read_text() == "new"
    assert list(tmp_path.iterdir()) == [place]


def fail(file):
    """Write half of a file."""
    file.write(b"ne")
    raise KeyboardInterrupt


def test_what_fails_leaves_the_old_file(tmp_path):
    """Whatever ends the writing, even an interrupt, leaves what was there and nothing beside it."""
    place = tmp_path / "file"
    place.write_text("old")

    with pytest.raises(KeyboardInterrupt), write_whole(place) as file:
        fail(file)

    assert place.read_text() == "old"
    assert list(tmp_path.iterdir()) == [place]
