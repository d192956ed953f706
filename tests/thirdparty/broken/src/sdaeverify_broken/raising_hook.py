"""A plugin whose hook raises."""

from sdaeverify import Scheme, hookimpl


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Raise."""
    raise RuntimeError("no schemes today")
