"""Langevin dynamics without constraints."""
