"""The cells and settings of a run, read from its folder without executing code."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import msgspec

from ..contracts.settings import Settings
from ..errors import UsageError
from .folders import RUN, run_of

# Exceptions raised by missing keys or values of another type.
WRONG = (KeyError, TypeError, msgspec.ValidationError)


@dataclass(frozen=True)
class SavedRun:
    """Selection and settings of a run, from ``run.json``.

    Attributes
    ----------
    folder : Path
    settings : Settings
    schemes, problems, measures : tuple of str
        Labels and names.
    files : tuple of str
        Plugin files that were named by path.
    """

    folder: Path
    settings: Settings
    schemes: tuple[str, ...]
    problems: tuple[str, ...]
    measures: tuple[str, ...]
    files: tuple[str, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names of the schemes, problems and measures of the run, without parameters."""
        return frozenset(label.partition("[")[0] for label in (*self.schemes, *self.problems, *self.measures))


def read_run(folder: Path) -> SavedRun:
    """Read the selection and settings of a run.

    Raises
    ------
    UsageError
        If the folder holds no run, or its ``run.json`` is not in the format of this program.
    """
    file, saved = folder / RUN, run_of(folder)
    try:
        names = msgspec.convert(saved["selection"], dict[str, tuple[str, ...]])
        files = msgspec.convert(saved.get("files", ()), tuple[str, ...])
        kinds = (names["schemes"], names["problems"], names["measures"])
        return SavedRun(folder, settings_of(saved, file), *kinds, files)
    except WRONG as error:
        raise _unlike(file, error) from error


def settings_of(run: Mapping[str, Any], file: object = RUN) -> Settings:
    """Return the settings in the contents of ``run.json``.

    Parameters
    ----------
    run : mapping
    file : Path
        File to name in the message.

    Raises
    ------
    UsageError
        If the contents are not in the format of this program.
    """
    try:
        # Earlier versions had no guard levels: all paths were on all levels.
        numbers = {"first_levels": run["settings"]["levels"], **run["settings"]}
        return msgspec.convert({each.name: numbers[each.name] for each in fields(Settings)}, Settings)
    except WRONG as error:
        raise _unlike(file, error) from error


def _unlike(file: object, error: Exception) -> UsageError:
    why = str(error) if isinstance(error, msgspec.ValidationError) else f"{type(error).__name__}: {error}"
    return UsageError(f"{file} does not tell of a run as this program writes it: {why}")
