"""Solvers of other libraries as schemes: each module is a plugin for one library, left out where that is missing."""
