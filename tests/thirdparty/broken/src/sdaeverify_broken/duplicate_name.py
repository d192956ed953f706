"""A plugin that registers a name that is taken."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import Scheme, hookimpl

from ._euler import Euler


@dataclass(frozen=True)
class Duplicate(Euler):
    """x+ = x + f h + B dW."""

    name: ClassVar[str] = "euler-maruyama"


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [Duplicate()]
