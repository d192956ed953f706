"""Schemes for constrained Langevin dynamics with stiffness 1/eps, and their limit."""
