"""Langevin dynamics with a heat bath, free or constrained."""
