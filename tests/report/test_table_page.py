"""A page of a table: digits that a reader uses, notes, and the figure within the file."""

from math import inf, nan
from pathlib import Path

import pandas as pd
import pytest

from sdaeverify.commands import TablePage


def test_numbers_have_five_digits_and_what_is_missing_is_empty():
    """The file beside the page has all digits."""
    table = pd.DataFrame({"x": [0.12345678901234567, nan, inf], "n": [1, 2, 3], "name": ["a", "b", None]})
    page = TablePage.of("Table", table, ["A note."])

    assert page.rows == [[0.12346, "1", "a"], ["", "2", "b"], ["inf", "3", ""]]
    assert (page.text, page.picture) == (["A note."], "")


@pytest.mark.parametrize(("suffix", "begin"), [(".svg", "data:image/svg+xml;base64,"), (".pdf", "")])
def test_a_figure_is_a_part_of_the_page_if_a_browser_draws_it(tmp_path: Path, suffix: str, begin: str):
    """The page is one file: a picture of another kind stays beside it."""
    file = tmp_path / f"figure{suffix}"
    file.write_text("<svg/>")
    found = TablePage.of("Table", pd.DataFrame({"x": [1.0]}), picture=file).picture

    assert found.startswith(begin)
    assert bool(found) == bool(begin)
