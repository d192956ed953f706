"""Contract and exactness of a scheme: what no order test sees, and what every order test relies on."""

from .breach import breach

__all__ = ["breach"]
