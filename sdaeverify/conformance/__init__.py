"""Contract and exactness of a scheme: what no order test sees, and what every order test relies on."""

from .violation import violation

__all__ = ["violation"]
