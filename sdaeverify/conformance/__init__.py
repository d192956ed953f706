"""Check the contract and exactness of a scheme, on which order tests rely but which they cannot test."""

from .violation import compared_steps, violation

__all__ = ["compared_steps", "violation"]
