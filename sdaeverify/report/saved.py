"""A run as its folder tells: which cells it was about, and with which settings. Text in, nothing is executed."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ..contracts.settings import Settings
from ..errors import SdaeverifyError, UsageError
from .folders import RUN, run_of


@dataclass(frozen=True)
class SavedRun:
    """What ``run.json`` says.

    Attributes
    ----------
    folder : Path
    settings : Settings
    schemes, problems, measures : tuple of str
        Labels and names.
    """

    folder: Path
    settings: Settings
    schemes: tuple[str, ...]
    problems: tuple[str, ...]
    measures: tuple[str, ...]


def read_run(folder: Path) -> SavedRun:
    """Read what a run was about.

    Raises
    ------
    UsageError
        If the folder holds no run, or its ``run.json`` is not as this program writes it.
    """
    file, saved = folder / RUN, run_of(folder)
    try:
        names = (_texts(saved["selection"][kind]) for kind in ("schemes", "problems", "measures"))
        return SavedRun(folder, settings_of(saved, file), *names)
    except (KeyError, TypeError) as error:
        raise _unlike(file, error) from error


def settings_of(run: Mapping[str, Any], file: object = RUN) -> Settings:
    """Return the settings of what ``run.json`` tells of a run.

    Parameters
    ----------
    run : mapping
    file : Path
        The file, to be named where it is not as it should be.

    Raises
    ------
    UsageError
        If it is not as this program writes it.
    """
    try:
        # Earlier versions knew no guards: all paths were on all levels.
        numbers = {"first_levels": run["settings"]["levels"], **run["settings"]}
        return Settings(**{f.name: _number(numbers[f.name], f.type) for f in fields(Settings)})
    except (KeyError, TypeError, ValueError, ArithmeticError) as error:
        raise _unlike(file, error) from error


def _unlike(file: object, error: Exception) -> UsageError:
    why = str(error) if isinstance(error, SdaeverifyError) else f"{type(error).__name__}: {error}"
    return UsageError(f"{file} does not tell of a run as this program writes it: {why}")


def _number(value: Any, kind: object) -> Any:
    wanted = float if kind in {float, "float"} else int
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"expected a number, got {value!r}")
    if wanted(value) != value:
        raise ValueError(f"expected a whole number, got {value!r}")
    return wanted(value)


def _texts(values: Any) -> tuple[str, ...]:
    if not (isinstance(values, list) and all(isinstance(value, str) for value in values)):
        raise TypeError(f"expected a list of names, got {values!r}")
    return tuple(values)
