"""Dynamics with an affine constraint, whose laws are all normal."""
