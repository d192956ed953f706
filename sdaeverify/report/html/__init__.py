"""The page of a run: one file that needs no network, its pictures drawn from the numbers of the tables."""

from .page import PAGE, page_text, remove_page, write_page
from .payload import payload

__all__ = ["PAGE", "page_text", "payload", "remove_page", "write_page"]
