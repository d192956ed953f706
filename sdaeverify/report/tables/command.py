"""The command that computes a cell again, to the last bit, from what ``run.json`` tells."""

import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from ...contracts.settings import Settings
from ..reading import Row, number, text
from ..saved import EARLIER, settings_of

CELL = ("scheme", "problem", "measure")


def reproduce(cell: Sequence[str], settings: Settings, plugins: Sequence[str] = ()) -> str:
    """Return the command for a cell.

    Parameters
    ----------
    cell : sequence of str
        Labels of scheme and problem, name of the measure.
    settings : Settings
    plugins : sequence of str
        Plugin files named by path.

    Returns
    -------
    str
    """
    default = Settings()
    words = ["python", "-m", "sdaeverify", "matrix"]
    words += [word for option, name in zip(("-s", "-p", "-m"), cell, strict=True) for word in (option, name)]
    words += ["--out", "reports/reproduced"]
    words += ["--paths", str(settings.paths), "--levels", f"{settings.steps[0]}..{settings.steps[-1]}"]
    if settings.guards is not settings:
        words += ["--guard-levels", str(settings.guard_levels)]
    words += ["--seed", str(settings.seed)]
    for name in ("confidence", "block", "looks", "family"):
        if getattr(settings, name) != getattr(default, name):
            words += [f"--{name}", str(getattr(settings, name))]
    return shlex.join([*words, *(word for plugin in plugins for word in ("--plugin", plugin))])


def command_of(row: Row, run: Mapping[str, Any]) -> str:
    """Return the command for the cell of a row; empty where a name of it is not registered.

    Parameters
    ----------
    row : mapping
        Of the verdicts.
    run : mapping
        The contents of ``run.json``.

    Raises
    ------
    UsageError
        If these are not as this program writes them.
    """
    runs = [run, *run.get(EARLIER, ())]
    place = int(number(row, "run")) if text(row, "run") else 0
    own, cell = runs[place] if place < len(runs) else run, [text(row, name) for name in CELL]
    if {*cell} & {*own.get("unnamed", ())}:
        return ""
    return reproduce(cell, settings_of(own), own.get("files", ()))
