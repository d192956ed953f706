"""Comparison of a gate with an earlier one, such as that of the base branch: claims whose status changed."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from ..contracts.finding import Status
from ..contracts.spelling import counted
from ..errors import UsageError
from ..report.folders import Key
from ..report.saved import GATE
from .gated import ABSENT, WORDS, StatusChange
from .outcomes import ORDER, Outcome

WRONG = (msgspec.DecodeError, msgspec.ValidationError, KeyError, TypeError, ValueError)


def read_gate(place: Path) -> dict[Key, Status]:
    """Return the status of each claim of an earlier gate.

    Parameters
    ----------
    place : Path
        ``gate.json``, or the folder that holds it.

    Raises
    ------
    UsageError
        If the file does not exist or was not written by a gate.
    """
    file = place / GATE if place.is_dir() else place
    try:
        found: Any = msgspec.json.decode(file.read_bytes())
        rows = found["outcomes"]
        return {Key(*(str(row[name] or "") for name in Key._fields)): Status(row["status"]) for row in rows}
    except OSError as error:
        raise UsageError(f"--against: cannot read {file}: {error.strerror or error}") from error
    except WRONG as error:
        raise UsageError(f"--against: {file} is not a {GATE} written by a gate") from error


def changes(before: Mapping[Key, Status], outcomes: Iterable[Outcome], *, narrowed: bool) -> tuple[StatusChange, ...]:
    """Return the changes of status, worst present status first; claims that are no longer gated come last.

    Parameters
    ----------
    before : mapping of Key to Status
    outcomes : iterable of Outcome
    narrowed : bool
        Whether only a part of the claims is gated, so that a missing claim is not reported as gone.
    """
    now = {outcome.key: outcome.status for outcome in outcomes}
    ranked = sorted(now, key=lambda key: (ORDER.index(now[key]), key))
    found = [
        StatusChange(key, WORDS[before[key]] if key in before else ABSENT, WORDS[now[key]])
        for key in ranked
        if before.get(key) is not now[key]
    ]
    gone = [] if narrowed else sorted(before.keys() - now.keys())
    return (*found, *(StatusChange(key, WORDS[before[key]], ABSENT) for key in gone))


def in_one_line(found: tuple[StatusChange, ...], place: Path) -> str:
    """Return the number of changed claims in a sentence."""
    return (
        f"against {place}: {counted(len(found), 'claim')} changed" if found else f"against {place}: nothing changed"
    )
