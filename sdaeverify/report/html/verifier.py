"""What is known of the verifier itself: the kill matrix and the calibration, from the reports beside a run."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .payload import to_json

KILLS, CALIBRATION = Path("selftest", "kill.csv"), Path("calibration", "calibration.csv")
NUMBERS = ("rate", "ci_low", "ci_high", "paths")
TEXTS = ("study", "case", "statistic", "promised", "agrees")


def verifier(reports: Path) -> dict[str, Any]:
    """Return what the reports of the self-test and of the calibration say; empty where there are none.

    Parameters
    ----------
    reports : Path
        Folder in which they have their folders.
    """
    kills, calibration = read_csv(reports / KILLS), read_csv(reports / CALIBRATION)
    return {
        **({"kills": {"head": kills[0], "rows": kills[1:]}} if len(kills) > 1 else {}),
        **({"calibration": coverage(calibration)} if len(calibration) > 1 else {}),
    }


def coverage(table: Sequence[Sequence[str]]) -> list[dict[str, Any]]:
    """Return the rows of a calibration, headings first, as the page reads them."""
    records = [dict(zip(table[0], row, strict=False)) for row in table[1:]]
    return [
        {**{name: one.get(name, "") for name in TEXTS}, **{name: _number(one.get(name, "")) for name in NUMBERS}}
        for one in records
    ]


def _number(text: str) -> float | str | None:
    try:
        return to_json(float(text))
    except ValueError:
        return None


def read_csv(file: Path) -> list[list[str]]:
    """Return the rows of a table, headings first; none where there is no such table."""
    try:
        with file.open(newline="", encoding="utf-8") as opened:
            return list(csv.reader(opened))
    except (OSError, ValueError, csv.Error):
        return []
