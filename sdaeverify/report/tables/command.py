"""Commands that reproduce a cell bit for bit from the contents of ``run.json``."""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ...contracts.settings import Settings
from ...registry.sources import plugin_options
from ..cells import Row, text
from ..folders import class_in
from ..saved import settings_of
from ..verdict_row import VerdictRow

CELL = ("scheme", "problem", "measure")
PYTHON = ("python", "-m", "sdaeverify")


def reproduce(cell: Sequence[str], settings: Settings, plugins: Sequence[str] = ()) -> str:
    """Return the command that reproduces a cell.

    Parameters
    ----------
    cell : sequence of str
        Labels of scheme and problem, and name of the measure.
    settings : Settings
    plugins : sequence of str
        Plugins as a registry names them: paths of files and texts of sources.

    Returns
    -------
    str
    """
    default = Settings()
    words = ["matrix"]
    words += [word for option, name in zip(("-s", "-p", "-m"), cell, strict=True) for word in (option, name)]
    words += ["--out", "reports/reproduced"]
    words += ["--paths", str(settings.paths), "--levels", f"{settings.steps[0]}..{settings.steps[-1]}"]
    if settings.guards is not settings:
        words += ["--first-levels", str(settings.first_levels)]
    words += ["--seed", str(settings.seed)]
    for name in ("confidence", "block", "max_looks", "tests_reserved"):
        if getattr(settings, name) != getattr(default, name):
            words += [f"--{name.replace('_', '-')}", str(getattr(settings, name))]
    return _joined(words, plugins)


def orders_command(scheme: str, kind: str, motions: int = 0, plugins: Sequence[str] = ()) -> str:
    """Return the command that tests the order conditions of a class for a scheme.

    Parameters
    ----------
    scheme, kind : str
        Label of the scheme, and name of the class.
    motions : int
        Number of Brownian motions; 0 for the default of the command.
    plugins : sequence of str
        Plugins as a registry names them: paths of files and texts of sources.
    """
    words = ["orders", scheme, "--class", kind]
    words += ["--motions", str(motions)] if motions > 1 else []
    return _joined(words, plugins)


def examination_command(cell: Sequence[str], words: Sequence[str], plugins: Sequence[str] = ()) -> str:
    """Return the command that reproduces a result of an examination.

    Parameters
    ----------
    cell : sequence of str
        Labels of scheme and problem, name of the measure.
    words : sequence of str
        Words of the examination, in which ``{scheme}``, ``{problem}`` and ``{measure}`` stand for the labels.
    plugins : sequence of str
        Plugins as a registry names them: paths of files and texts of sources.
    """
    labels = {f"{{{kind}}}": name for kind, name in zip(CELL, cell, strict=True)}
    return _joined([labels.get(word, word) for word in words], plugins)


def _joined(words: Sequence[str], plugins: Sequence[str]) -> str:
    return shlex.join([*PYTHON, *words, *plugin_options(plugins)])


def command_of(row: Row, run: Mapping[str, Any]) -> str:
    """Return the command that reproduces the cell of a row; see `commands_of`."""
    return commands_of([row], run)[0]


def commands_of(rows: Iterable[Row], run: Mapping[str, Any]) -> list[str]:
    """Return the commands that reproduce the cells of rows; empty if a name is not registered.

    Parameters
    ----------
    rows : iterable of mapping
        Rows of the table of verdicts.
    run : mapping
        The contents of ``run.json``.

    Raises
    ------
    UsageError
        If the contents are not in the format of this program.
    """
    settings, unnamed = settings_of(run), {*run.get("unnamed", ())}
    cells = ([text(row, name) for name in CELL] for row in rows)
    return ["" if {*cell} & unnamed else _command(cell, settings, run) for cell in cells]


def _command(cell: Sequence[str], settings: Settings, run: Mapping[str, Any]) -> str:
    plugins, words = run.get("files", ()), run.get("examined", {}).get(cell[2])
    if (kind := class_in(cell[1])) is not None:
        return orders_command(cell[0], kind, plugins=plugins)
    return reproduce(cell, settings, plugins) if words is None else examination_command(cell, words, plugins)


def records_of(rows: Iterable[VerdictRow], run: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return rows for JSON, each with the command that reproduces its cell; see `commands_of`."""
    told = list(rows)
    commands = commands_of([row.cells for row in told], run)
    return [{**row.record, "reproduce": command or None} for row, command in zip(told, commands, strict=True)]
