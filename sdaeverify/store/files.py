"""A file of evidence: numbered arrays and a header in JSON; reading it executes nothing.

It is an uncompressed ``.npz``. What claims to be larger than the file is refused, so that a file from elsewhere
cannot fill the memory, and objects are never unpickled.
"""

import json
import zipfile
from collections.abc import Mapping, Sequence
from functools import reduce
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..contracts.tally import Tally
from ..errors import FAULTS
from ..simulate.behaviour import Behaviour, differing
from ..simulate.ensemble import Entry, LaneEvidence
from .atomic import written
from .keys import Ingredients

FORMAT = 2
HEADER = "header"
KINDS = ("sums", "maxima", "largest")
# Kinds of arrays that evidence is made of: truth values, whole numbers, numbers.
NUMBERS = "biuf"


class MeasureRecord(NamedTuple):
    """Evidence of one measure, and what determines it beside the lane."""

    ingredients: Ingredients
    sampled: Tally
    probed: Tally


class StoredLane(NamedTuple):
    """Evidence on a scheme from one block of paths of a problem.

    Attributes
    ----------
    ingredients : mapping of str to str
        What determines it; ``scheme``, ``problem`` and ``index`` name it.
    behaviour : Behaviour
        What scheme and problem did, as digests.
    health : Tally
    seconds : float
    paths : int
    measures : mapping of str to MeasureRecord
    """

    ingredients: Ingredients
    behaviour: Behaviour
    health: Tally
    seconds: float
    paths: int
    measures: Mapping[str, MeasureRecord]

    @property
    def scheme(self) -> str:
        """Label of the scheme."""
        return self.ingredients["scheme"]

    @property
    def problem(self) -> str:
        """Label of the problem."""
        return self.ingredients["problem"]

    @property
    def block(self) -> int:
        """Index of the block."""
        return int(self.ingredients["index"])


def write_lane(lane: StoredLane, path: Path) -> None:
    """Write a file."""
    arrays: list[Array] = []
    header = json.dumps(_header(lane, arrays)).encode()
    numbered = {str(index): array for index, array in enumerate(arrays)}
    path.parent.mkdir(parents=True, exist_ok=True)
    with written(path) as file:
        np.savez(file, allow_pickle=False, **{HEADER: np.frombuffer(header, dtype=np.uint8)}, **numbered)


def read_lane(path: Path) -> StoredLane | None:
    """Return what a file holds; None if it is damaged or no such file."""
    try:
        with _opened(path) as file:
            return _lane(_read_header(file), file)
    except FAULTS:
        return None


def read_ingredients(path: Path) -> Ingredients | None:
    """Return what determines the evidence in a file, without reading the evidence; None if it is damaged."""
    try:
        with _opened(path) as file:
            return _texts(_read_header(file)["ingredients"])
    except FAULTS:
        return None


def _header(lane: StoredLane, arrays: list[Array]) -> dict[str, object]:
    return {
        "format": FORMAT,
        "ingredients": dict(lane.ingredients),
        "behaviour": lane.behaviour._asdict(),
        "seconds": lane.seconds,
        "paths": lane.paths,
        "health": _place(lane.health, arrays),
        "measures": {
            name: {
                "ingredients": dict(record.ingredients),
                "sampled": _place(record.sampled, arrays),
                "probed": _place(record.probed, arrays),
            }
            for name, record in lane.measures.items()
        },
    }


def _place(tally: Tally, arrays: list[Array]) -> dict[str, dict[str, int]]:
    """Put the arrays of a tally into a list and return where they are."""
    places: dict[str, dict[str, int]] = {}
    for kind in KINDS:
        places[kind] = {}
        for name, value in getattr(tally, kind).items():
            places[kind][name] = len(arrays)
            arrays.append(np.asarray(value))
    return places


def _opened(path: Path) -> Any:
    # What is no file, such as a pipe, might never come to an end.
    if not path.is_file():
        raise FileNotFoundError(path)
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    packed = any(member.compress_type != zipfile.ZIP_STORED for member in members)
    if packed or sum(member.file_size for member in members) > path.stat().st_size:
        raise ValueError("not written by this program")
    return np.load(path, allow_pickle=False)


def _read_header(file: Any) -> dict[str, Any]:
    header: dict[str, Any] = json.loads(file[HEADER].tobytes())
    if header["format"] != FORMAT:
        raise ValueError("another format")
    return header


def _lane(header: dict[str, Any], file: Any) -> StoredLane:
    records = {
        str(name): MeasureRecord(
            _texts(record["ingredients"]), _tally(record["sampled"], file), _tally(record["probed"], file)
        )
        for name, record in header["measures"].items()
    }
    health, behaviour = _tally(header["health"], file), Behaviour(**_texts(header["behaviour"]))
    seconds, paths = float(header["seconds"]), int(header["paths"])
    return StoredLane(_texts(header["ingredients"]), behaviour, health, seconds, paths, records)


def _tally(places: dict[str, dict[str, int]], file: Any) -> Tally:
    return Tally(*({str(name): _numbers(file[str(int(at))]) for name, at in places[kind].items()} for kind in KINDS))


def _numbers(array: Array) -> Array:
    if array.dtype.kind not in NUMBERS:
        raise ValueError("no numbers")
    return array


def _texts(values: dict[str, Any]) -> Ingredients:
    return {str(name): str(value) for name, value in values.items()}


# Evidence on some measures of a scheme put together with that on its others.


def joined(entry: Entry, parts: Sequence[tuple[Entry, LaneEvidence]]) -> LaneEvidence:
    """Return the evidence on an entry from parts of its measures.

    Parameters
    ----------
    entry : Entry
    parts : sequence of (Entry, LaneEvidence)
        Of the same scheme; together they have all its measures.
    """
    where = {m.name: (lane, index) for part, lane in parts for index, m in enumerate(part.measures)}
    found = [where[measure.name] for measure in entry.measures]
    lanes = [lane for _, lane in parts]
    did = list(dict.fromkeys(lane.behaviour for lane in lanes if lane.behaviour))
    return LaneEvidence(
        tuple(lane.tallies[index] for lane, index in found),
        tuple(lane.probes[index] for lane, index in found),
        reduce(fuller, (lane.health for lane in lanes)),
        sum(lane.seconds for lane in lanes),
        tuple(lane.errors[index] or differing(*did) for lane, index in found),
        max(lane.paths for lane in lanes),
        next((lane.violation for lane in lanes if lane.violation), ""),
        did[0] if did else None,
    )


def fuller(a: Tally, b: Tally) -> Tally:
    """Return the health that counts more steps: a lane that only evaluates the one-step map makes none."""
    return b if _steps(b) > _steps(a) else a


def _steps(health: Tally) -> float:
    return float(health.sums["steps"].sum()) if "steps" in health.sums else -1.0
