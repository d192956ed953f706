"""Texts of plugins in Markdown."""

import pytest

from facade import escape


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("gbm[a=1,b=0.1]", "gbm[a=1,b=0.1]"),
        ("a\n# heading", "a\\n# heading"),
        ("a|b", "a\\|b"),
        ("<img src=x>&lt;", "&lt;img src=x>&amp;lt;"),
        ("![x](http://example)", "![x]&#40;http://example)"),
        ("`code`", "&#96;code&#96;"),
        ("\x9b2J\u202e", "\\x9b2J\\u202e"),
    ],
)
def test_no_text_is_markup(text, shown):
    """Line breaks, cells, tags, links, code and what cannot be seen are shown in letters."""
    assert escape(text) == shown
