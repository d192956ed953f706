"""Files of a run, and what texts of plugins may do in them."""

import csv
import io

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from facade import FORMULA, harmless, write_table

ANY = st.text(st.characters(), max_size=12)
# What is looked for is rare in texts made of all letters.
NASTY = st.builds(
    "{}{}{}".format, st.sampled_from(["", " ", "\t", "\r", "\n", "\x1b[2J"]), st.sampled_from([*FORMULA, ""]), ANY
)
TEXTS = NASTY | ANY


def read_back(table, tmp_path_factory):
    path = tmp_path_factory.mktemp("table") / "table.csv"
    write_table(table, path)
    return list(csv.reader(io.StringIO(path.read_text(encoding="utf-8"), newline="")))


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


@given(heading=TEXTS.filter(bool), text=TEXTS)
def test_texts_neither_steer_a_terminal_nor_are_formulas(tmp_path_factory, heading, text):
    """Whatever a cell or a heading says, what is read back has no control character and begins no formula."""
    for cell in (cell for row in read_back(pd.DataFrame({heading: [text]}), tmp_path_factory) for cell in row):
        assert cell.isprintable()
        assert is_number(cell) or not cell.lstrip().startswith(FORMULA)


@given(values=st.lists(st.floats() | st.integers(), min_size=1, max_size=5))
def test_numbers_are_written_as_they_are(tmp_path_factory, values):
    """Numbers keep their sign and all their digits, in columns of numbers and beside texts."""
    numbers = pd.DataFrame({"mixed": pd.Series([*values, "text"], dtype=object)})
    (_, *rows) = read_back(numbers, tmp_path_factory)

    for (cell, *_), value in zip(rows, values, strict=False):
        assert cell == ("" if value != value else str(value))  # noqa: PLR0124 - NaN


def test_columns_of_numbers_keep_their_type(tmp_path_factory):
    """Whole numbers that some rows leave out stay whole, and floats have all digits."""
    table = pd.DataFrame({"whole": pd.array([-1, None], dtype="Int64"), "real": [-0.1, np.nan], "name": ["-x", None]})

    assert read_back(table, tmp_path_factory) == [["whole", "real", "name"], ["-1", "-0.1", "'-x"], ["", "", ""]]


@pytest.mark.parametrize(
    ("text", "safe"),
    [
        ("=HYPERLINK(a)", "'=HYPERLINK(a)"),
        (" @sum", "' @sum"),
        ("\t=1", "\\t=1"),
        ("-1.5e-3", "-1.5e-3"),
        ("-inf", "-inf"),
        ("-1+cmd", "'-1+cmd"),
        ("order >= 1", "order >= 1"),
    ],
)
def test_what_is_changed(text, safe):
    """A formula gets an apostrophe in front; a number and a text with signs inside do not."""
    assert harmless(text) == safe


def test_a_table_is_parquet_too_where_that_can_be_written(tmp_path):
    """The same rows, numbers as numbers to the last bit."""
    pytest.importorskip("pyarrow", reason="Parquet needs pyarrow")
    table = pd.DataFrame({"name": ["a", "b"], "number": [1.0 / 3.0, float("inf")]})
    write_table(table, tmp_path / "t.csv")
    assert pd.read_parquet(tmp_path / "t.parquet").to_dict("list") == table.to_dict("list")
