"""Tables of the site on narrow screens: each cell has the heading of its column."""

import importlib.util
import re
from pathlib import Path

import pytest

FILE = Path(__file__).parents[1] / "docs" / "_ext" / "narrow.py"
pytest.importorskip("sphinx", reason="needs the extra docs")


@pytest.fixture(scope="module")
def label_cells():
    """Return the function of the site's extension."""
    spec = importlib.util.spec_from_file_location("narrow", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.label_cells


def table(headings, row):
    """Return a table of one row as Sphinx writes it."""
    head = "".join(f'<th class="head"><p>{each}</p></th>' for each in headings)
    cells = "".join(f"<td><p>{each}</p></td>" for each in row)
    return f'<table class="table">\n<thead>\n<tr>{head}</tr>\n</thead>\n<tbody>\n<tr>{cells}</tr>\n</tbody>\n</table>'


def test_empty_cells_are_marked(label_cells):
    """They are left out of a block; a cell with a picture alone is not empty."""
    told = label_cells(table("abc", ("1", "", '<img src="x">')))
    assert [" data-empty" in cell for cell in re.findall(r"<td[^>]*>", told)] == [False, True, False]


def test_cells_have_the_heading_of_their_column(label_cells):
    """Markup of a heading is left out, and quotes are escaped."""
    told = label_cells(f"<p>before</p>{table(['<code>x</code> &amp; y', 'a &quot;b&quot;', 'c'], '123')}<p>after</p>")
    assert re.findall(r'data-label="([^"]*)"', told) == ["x &amp; y", "a &quot;b&quot;", "c"]
    assert 'class="stacked table"' in told
    assert told.startswith("<p>before</p>")
    assert told.endswith("<p>after</p>")


@pytest.mark.parametrize(
    "body", [table("a", "1"), table("abc", "123").replace("<td>", '<td colspan="2">'), "<p>text</p>"]
)
def test_other_tables_are_as_they_were(label_cells, body):
    """One column fits a narrow screen, and a cell of several columns has no one heading."""
    assert label_cells(body) == body
