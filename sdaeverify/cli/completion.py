"""Shell completion of registered names, as in ``-s mil<TAB>``."""

from collections.abc import Callable

import click
from click.shell_completion import CompletionItem

from ..errors import SdaeverifyError
from .loading import load_quietly

Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def names_of(*kinds: str) -> Complete:
    """Return a completion of names, which also completes the last name of a comma-separated list.

    Parameters
    ----------
    *kinds : str
        ``schemes``, ``problems`` or ``measures``.
    """

    def complete(context: click.Context, _: click.Parameter, incomplete: str) -> list[CompletionItem]:
        before, comma, begun = incomplete.rpartition(",")
        try:
            registry = load_quietly(context.params.get("plugins") or ())
        except SdaeverifyError:
            # Completion cannot show a message; the command reports the error when it is run.
            return []
        names = {name for kind in kinds for name in getattr(registry, kind)}
        return [CompletionItem(f"{before}{comma}{name}") for name in sorted(names) if name.startswith(begun)]

    return complete
