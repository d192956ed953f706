"""Contract and exactness of a scheme: what no order test sees, and what every order test relies on."""

from .violation import compared_steps, violation

__all__ = ["compared_steps", "violation"]
