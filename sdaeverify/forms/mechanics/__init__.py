"""Constrained stochastic mechanics: the holonomic form, its Jacobians and the structure of what couples."""
