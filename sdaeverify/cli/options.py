"""Options: how they are read and what their help says."""

import re
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import click

from ..errors import UsageError
from ..settings import Settings

Command = TypeVar("Command", bound=Callable[..., Any])

_COUNT = re.compile(r"[0-9]{1,9}")
_RANGE = re.compile(r"([0-9]{1,9})\.\.([0-9]{1,9})")


def once(*names: str, default: object = None, **attributes: Any) -> Callable[[Command], Command]:
    """Return an option with one value: giving it twice with different values contradicts itself."""

    def one(_: click.Context, parameter: click.Parameter, values: Sequence[object]) -> object:
        different = list(dict.fromkeys(values))
        if len(different) > 1:
            listing = " and ".join(str(value) for value in different)
            raise UsageError(f"contradictory options: {parameter.opts[-1]} is given as {listing}")
        return different[0] if different else None

    return click.option(
        *names,
        multiple=True,
        default=() if default is None else (default,),
        show_default=default is not None,
        callback=one,
        **attributes,
    )


plugins = click.option(
    "--plugin", "plugins", metavar="FILE", multiple=True, help="Plugin without packaging, a Python file. Repeatable."
)


def levels_text(settings: Settings) -> str:
    """Return the step sizes as ``--levels`` takes them."""
    return f"{settings.steps[0]}..{settings.steps[-1]}"


def read_levels(text: str) -> tuple[int, int]:
    """Return the coarsest number of steps and the number of levels.

    Parameters
    ----------
    text : str
        A number of levels, or ``COARSEST..FINEST`` with FINEST = COARSEST 2^k.

    Raises
    ------
    UsageError
        If it is neither.
    """
    if _COUNT.fullmatch(text):
        return Settings().coarsest, int(text)
    match = _RANGE.fullmatch(text)
    coarsest, finest = (int(steps) for steps in match.groups()) if match else (0, 0)
    doublings = finest // coarsest if coarsest else 0
    if doublings < 1 or coarsest * doublings != finest or doublings.bit_count() > 1:
        expected = f"a number of levels or COARSEST..FINEST steps such as {levels_text(Settings())}"
        raise UsageError(
            f"--levels expects {expected}, the finest being the coarsest times a power of 2, got {text!r}"
        )
    return coarsest, doublings.bit_length()
