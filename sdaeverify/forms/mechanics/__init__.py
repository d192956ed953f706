"""Constrained stochastic mechanics: the holonomic form, its Jacobians and its coupling structure."""
