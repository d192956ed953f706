"""Names of what is registered, for the completion of a shell: ``-s mil<TAB>``."""

from collections.abc import Callable

import click
from click.shell_completion import CompletionItem

from ..errors import SdaeverifyError
from .loading import load_quietly

Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def names_of(*kinds: str) -> Complete:
    """Return a completion of names, also of the last one of a list with commas.

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
            # A shell has no place for a message; the command says it when it is run.
            return []
        names = {name for kind in kinds for name in getattr(registry, kind)}
        return [CompletionItem(f"{before}{comma}{name}") for name in sorted(names) if name.startswith(begun)]

    return complete
