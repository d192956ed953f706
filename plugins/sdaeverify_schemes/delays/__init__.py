"""Stochastic theta methods for index-1 equations with a delay."""
