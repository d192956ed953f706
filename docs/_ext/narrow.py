"""Tables on narrow screens: each cell knows the heading of its column, which the style sheet shows before it."""

import re
from html import escape, unescape
from typing import Any

from sphinx.application import Sphinx

TABLE = re.compile(r"<table\b.*?</table>", re.DOTALL)
HEADING = re.compile(r"<th\b[^>]*>(.*?)</th>", re.DOTALL)
ROW = re.compile(r"<tr\b.*?</tr>", re.DOTALL)
CELL = re.compile(r"<td\b([^>]*>)(.*?)</td>", re.DOTALL)
MARKUP = re.compile(r"<[^>]+>")
# A table of one column fits as it is.
FEWEST = 2


def label_cells(body: str) -> str:
    """Return a page whose tables of several columns are ``stacked``, with a ``data-label`` in each cell."""
    return TABLE.sub(lambda found: _label(found.group()), body)


def _label(table: str) -> str:
    head, end, rows = table.partition("</thead>")
    labels = [" ".join(unescape(MARKUP.sub("", told)).split()) for told in HEADING.findall(head)]
    # Cells that span several columns have no heading of their own.
    if not end or len(labels) < FEWEST or "colspan" in table:
        return table
    stacked = re.sub(r'<table\b(.*?)class="', r'<table\1class="stacked ', head, count=1, flags=re.DOTALL)
    return stacked + end + ROW.sub(lambda found: _label_row(found.group(), labels), rows)


def _label_row(row: str, labels: list[str]) -> str:
    remaining = iter(labels)
    return CELL.sub(lambda found: _label_cell(found.group(1), found.group(2), next(remaining, "")), row)


def _label_cell(start: str, content: str, label: str) -> str:
    # An empty cell is left out where rows are blocks.
    empty = "" if MARKUP.sub("", content).strip() or "<img" in content else " data-empty"
    return f'<td data-label="{escape(label, quote=True)}"{empty}{start}{content}</td>'


def _on_page(app: Sphinx, page: str, template: str, context: dict[str, Any], tree: object) -> None:
    if "<table" in context.get("body", ""):
        context["body"] = label_cells(context["body"])


def setup(app: Sphinx) -> dict[str, Any]:
    """Label cells when a page is written."""
    app.connect("html-page-context", _on_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
