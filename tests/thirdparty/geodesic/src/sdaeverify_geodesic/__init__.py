"""Geodesic BAOAB and a problem to try it on: each module is a plugin of its own."""
