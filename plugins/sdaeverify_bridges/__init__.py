"""Solvers of other libraries as schemes: one plugin per library, left out if the library is missing."""
