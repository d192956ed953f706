"""A plugin without fault, which its neighbours must not cost anything."""

from typing import ClassVar

from sdaeverify import Scheme, hookimpl

from ._euler import Euler


class Sound(Euler):
    """x+ = x + f h + B dW."""

    name: ClassVar[str] = "sound-euler"


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [Sound()]
