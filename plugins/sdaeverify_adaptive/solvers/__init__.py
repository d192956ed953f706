"""Shipped solvers: examples for authors, whose claims the verifier must not refute."""
