"""Solvers that are shipped: what an author of one can begin with, and what the verifier must not refute."""
