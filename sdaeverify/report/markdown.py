"""Texts of plugins in Markdown: shown as they are, never markup."""

from .plain import visible


def escape(text: str) -> str:
    """Return a text that stays in its line and in its cell, and is neither HTML, nor code, nor a link or image."""
    safe = visible(text).replace("&", "&amp;").replace("<", "&lt;").replace("`", "&#96;")
    return safe.replace("](", "]&#40;").replace("|", "\\|")
