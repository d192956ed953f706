"""A plugin whose hook asks for an argument that nobody gives."""

from sdaeverify import Scheme, hookimpl


@hookimpl
def sdaeverify_schemes(settings: object) -> list[Scheme]:
    """Ask for settings, which the hook does not have."""
    return []
