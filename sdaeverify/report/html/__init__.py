"""The page of a run: one file that needs no network, its pictures drawn from the numbers of the tables."""

from .page import PAGE, TablePage, page_text, remove_page, write_page, write_tables
from .payload import payload
from .verifier import verifier

__all__ = ["PAGE", "TablePage", "page_text", "payload", "remove_page", "verifier", "write_page", "write_tables"]
