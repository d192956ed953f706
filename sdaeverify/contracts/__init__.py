"""Contracts of plugins: schemes, claims, measures, settings, labels, and how schemes match problems."""
