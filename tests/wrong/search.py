"""Judge wrong schemes and note each: `python tests/wrong/search.py reports/wrong-schemes/schemes.csv 0-245`.

A line for each claim: what is wrong, what the program says, how far the limit really is from the solution, and
whether the resolution that a verified claim was told with is larger than that. Schemes that are in the file already
are not run again. At the end it prints how often each outcome came.
"""

import csv
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from math import isinf, isnan, nan
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from sdaeverify import verify
from statistical.search import numbers
from wrong.draws import Drawn, drawn
from wrong.truth import Size, true_errors

SETTINGS: dict[str, Any] = {"paths": 4096}
MEASURES = ("strong", "weak")
COLUMNS = (
    "number",
    "wrong",
    "problem",
    "measure",
    "quantity",
    "claim",
    "verdict",
    "outcome",
    "relative",
    "resolution",
)
COLUMNS += ("error", "std_error", "size", "local_order", "path_order", "decided_by", "seconds", "reason")
# Standard errors by which an error has to differ from 0, and from a resolution.
CERTAIN = 3.0
# Paths that settle which of the two is larger.
SHARPER = 2**18
NO_ERROR, UNTOLD, UNBOUNDED = "no error", "no resolution told", "resolution is infinite"
ABOVE, BELOW = "error above resolution", "error below resolution"


def judged(case: Drawn, sizes: Mapping[tuple[str, str], Size] | None = None) -> list[dict[str, Any]]:
    """Return a line for each claim of a wrong scheme.

    Errors that seem to be larger than a resolution, but not for certain, are found again with more paths.

    Parameters
    ----------
    case : Drawn
    sizes : mapping, optional
        As `true_errors` returns them, which is called if it is left out.
    """
    sizes, begun = true_errors(case) if sizes is None else sizes, time.monotonic()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        table = verify([case.scheme], [case.problem], MEASURES, **SETTINGS).verdicts
    rows = table[table.scheme == case.scheme.label].to_dict("records")
    seconds = {"seconds": round(time.monotonic() - begun, 2)}
    lines = [line | seconds for line in _lines(case, rows, sizes)]
    if any(line["outcome"] == BELOW and float(line["relative"]) > float(line["resolution"]) for line in lines):
        lines = [line | seconds for line in _lines(case, rows, true_errors(case, paths=SHARPER))]
    return lines


def _lines(
    case: Drawn, rows: Sequence[Mapping[str, Any]], sizes: Mapping[tuple[str, str], Size]
) -> Iterator[dict[str, Any]]:
    for row in rows:
        if row["claim"] and (size := _size(sizes, row["measure"], row["quantity"])) is not None:
            yield _line(case, row, size)


def _size(sizes: Mapping[tuple[str, str], Size], measure: str, quantity: str) -> Size | None:
    """Return the error of a quantity; the largest one where a verdict is about all of them."""
    if quantity:
        return sizes.get((measure, quantity))
    return max((size for (of, _), size in sizes.items() if of == measure), key=lambda size: size.relative)


def _line(case: Drawn, row: Mapping[str, Any], size: Size) -> dict[str, Any]:
    told = row.get("resolution")
    resolution = float(told) if told not in {None, ""} else nan
    numbers = {"relative": size.relative, **size._asdict(), "resolution": resolution}
    kept = {name: row[name] for name in COLUMNS if name in row and name not in numbers}
    line = {"number": case.number, "wrong": case.told, "outcome": outcome(str(row["verdict"]), size, resolution)}
    return kept | {name: "" if isnan(value) else f"{value:.4g}" for name, value in numbers.items()} | line


def outcome(verdict: str, size: Size, resolution: float) -> str:
    """Return what a verdict comes to: of a verified claim, how its resolution and the error of the limit compare."""
    if verdict != "verified":
        return verdict
    if size.error <= CERTAIN * size.std_error:
        return NO_ERROR
    if isnan(resolution):
        return UNTOLD
    if isinf(resolution):
        return UNBOUNDED
    least = (size.error - CERTAIN * size.std_error) / size.size
    return BELOW if least <= resolution else ABOVE


def search(kept: Path, chosen: Sequence[int]) -> Counter[str]:
    """Run the schemes that are not in the file, append them, and count the outcomes of all."""
    known = _read(kept)
    done = {int(line["number"]) for line in known}
    with kept.open("a", newline="") as out:
        writer = csv.DictWriter(out, COLUMNS, extrasaction="ignore", lineterminator="\n")
        if not known:
            writer.writeheader()
        for number in (number for number in chosen if number not in done):
            writer.writerows(judged(drawn(number)))
            out.flush()
    return Counter(line["outcome"] for line in _read(kept))


def _read(kept: Path) -> list[dict[str, str]]:
    if not kept.exists():
        return []
    with kept.open(newline="") as given:
        return list(csv.DictReader(given))


if __name__ == "__main__":
    for what, count in sorted(search(Path(sys.argv[1]), list(numbers(sys.argv[2:]))).items()):
        print(f"{what}: {count}")
