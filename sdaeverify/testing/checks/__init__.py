"""Checks of the conformance kit, one topic per file."""
