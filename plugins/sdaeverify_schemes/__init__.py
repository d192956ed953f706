"""Shipped schemes, one folder per family: each module is a plugin, and a new scheme is a new module."""
