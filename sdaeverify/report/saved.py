"""The cells, claims and settings of a run, read from its folder without executing code."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import msgspec

from ..contracts.scheme import Claim, Scheme
from ..contracts.settings import Settings
from ..errors import UsageError
from .folders import RUN, run_of

# File name of the report of a gate.
GATE = "gate.json"
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
        Plugins that were named: paths of files, and texts of sources.
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


@dataclass(frozen=True)
class SavedClaim:
    """A claim of a scheme of a run, in the format of ``run.json``.

    Attributes
    ----------
    scheme, measure, claim, source : str
        Label of the scheme, name of the measure, claim in words, and source of the claim.
    quantities, when : tuple of str
        Quantities of the claim, all if empty; and traits that a problem must have.
    """

    scheme: str
    measure: str
    claim: str
    source: str
    quantities: tuple[str, ...] = ()
    when: tuple[str, ...] = ()

    @classmethod
    def of(cls, scheme: Scheme, claim: Claim) -> "SavedClaim":
        """Convert a claim of a scheme."""
        return cls(scheme.label, claim.measure, str(claim), claim.source, claim.quantities, tuple(sorted(claim.when)))


@dataclass(frozen=True)
class SavedAttack:
    """Result of a hunt of a gate for the claims about a measure, in the format of ``gate.json``.

    Attributes
    ----------
    scheme, measure, form : str
        Label of the scheme, name of the measure, form of the examples.
    claims : dict of str to int
        Number of examples to which each claim applies.
    refuted : str
        Claim that an example refutes and a run on the example confirms as refuted; empty if there is none.
    """

    scheme: str
    measure: str
    form: str
    claims: dict[str, int]
    refuted: str = ""


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


def claims_of(run: Mapping[str, Any], file: object = RUN) -> tuple[SavedClaim, ...]:
    """Return the claims of the schemes of a run; empty for a run of an earlier version. See `settings_of`."""
    try:
        return msgspec.convert(run.get("claims", ()), tuple[SavedClaim, ...])
    except WRONG as error:
        raise _unlike(file, error) from error


def is_of_run(report: Mapping[str, Any], folder: Path) -> bool:
    """Return whether the contents of ``gate.json`` are about the run that the folder has now.

    A later run in the same folder has another date; reports of earlier versions have none.
    """
    return report.get("date", "") in {"", run_of(folder).get("date")}


def read_attacks(folder: Path) -> tuple[tuple[SavedAttack, ...], str]:
    """Return the results of the hunt of a gate, and why there are none although ``gate.json`` has some.

    There are none if the folder is not that of a gate with a hunt, or if it has a later run.

    Raises
    ------
    UsageError
        If ``gate.json`` is not in the format of this program.
    """
    file = folder / GATE
    if not file.is_file():
        return (), ""
    try:
        report = json.loads(file.read_bytes())
        attacks = msgspec.convert(report.get("attacks", ()), tuple[SavedAttack, ...])
    except (OSError, ValueError, AttributeError, RecursionError) as error:
        raise UsageError(f"{file} is not as this program writes it: {error}") from error
    if attacks and not is_of_run(report, folder):
        return (), f"{file} is about an earlier run in this folder: its hunt is left out; run gate again"
    return attacks, ""


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
    return UsageError(f"{file} does not describe a run in the format of this program: {why}")
