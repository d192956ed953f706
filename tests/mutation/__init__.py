"""Variants of the shipped schemes: mutants, which are wrong by a known amount, and rewritings, which are not."""
