"""Diffusions on tori, by penalty and in a tube."""
