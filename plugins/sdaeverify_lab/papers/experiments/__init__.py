"""Shipped tables and figures of papers, one per file, for `reproduce`."""
