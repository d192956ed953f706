"""Diffusions on closed curves in the plane, and their geometry."""
