"""Diffusions on tori, with two constraint functions for the same surface."""
