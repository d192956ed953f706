"""Why the folder of a run holds no evidence that could be compared."""

import csv
from collections.abc import Iterator
from pathlib import Path

from ...report.folders import VERDICTS

# Where the contract of a scheme is broken, nothing is simulated.
BEFORE_ANY_PATH = "T0"


def why_absent(folder: Path, damaged: int) -> str:
    """Return in one line why there is no evidence of the run, and what to do about it where that is known.

    Parameters
    ----------
    folder : Path
        Of the run.
    damaged : int
        Files of evidence that cannot be read.
    """
    if damaged:
        return f"{damages(folder, damaged)}; run matrix or gate with --out {folder}"
    reasons = list(_reasons(folder))
    more = f" (and {len(reasons) - 1} more cells)" if len(reasons) > 1 else ""
    cause = f"{reasons[0]}{more}" if reasons else f"run matrix or gate with --out {folder}"
    return f"{folder} holds no evidence of the run in it; {cause}"


def damages(folder: Path, damaged: int) -> str:
    """Return how many files of evidence are damaged, in words."""
    one = damaged == 1
    return f"{damaged} {'file' if one else 'files'} of evidence in {folder} {'is' if one else 'are'} damaged"


def _reasons(folder: Path) -> Iterator[str]:
    try:
        with (folder / VERDICTS).open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except (OSError, ValueError, csv.Error):
        return
    for row in rows:
        told = {name: str(text or "") for name, text in row.items()}
        early = " before any path" if told.get("decided_by") == BEFORE_ANY_PATH else ""
        if told.get("reason"):
            cell = f"{told.get('scheme')} on {told.get('problem')}, {told.get('measure')}"
            yield f"{cell}: {told.get('verdict')}{early}: {told['reason']}"
