"""Evidence on a lane as bytes: a header in JSON and the numbers of all arrays, as numpy saves them.

Reading them executes nothing. What unpacks to more than any evidence takes is refused, so that a file from elsewhere
cannot fill the memory.
"""

import json
import zlib
from collections.abc import Mapping, Sequence
from functools import reduce
from io import BytesIO
from math import prod
from typing import Any, NamedTuple
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile

import numpy as np

from ..arrays import Array
from ..contracts.tally import Tally
from ..errors import FAULTS
from ..simulate.ensemble import Behaviour, Entry, SchemeEvidence
from .behaviour import differing
from .files import Opened
from .keys import Ingredients

FORMAT = 5
KINDS = ("sums", "maxima", "largest")
# Bytes of all that is unpacked.
LARGEST = 2**28


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
    opened : tuple of (str, str)
        Files that its code had opened, with hashes of what they held.
    """

    ingredients: Ingredients
    behaviour: Behaviour
    health: Tally
    seconds: float
    paths: int
    measures: Mapping[str, MeasureRecord]
    opened: Opened = ()

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


def pack_lane(lane: StoredLane) -> bytes:
    """Return evidence as bytes.

    Raises
    ------
    OSError
        If it is more than could be read.
    """
    arrays: list[Array] = []
    told = {
        "format": FORMAT,
        "ingredients": dict(lane.ingredients),
        "behaviour": lane.behaviour._asdict(),
        "opened": dict(lane.opened),
        "seconds": lane.seconds,
        "paths": lane.paths,
        "health": _place(lane.health, arrays),
        "measures": {name: _place_record(record, arrays) for name, record in lane.measures.items()},
    }
    header = np.frombuffer(json.dumps(told).encode(), dtype=np.uint8)
    numbers = np.concatenate([np.zeros(0), *(array.ravel() for array in arrays)])
    if header.nbytes + numbers.nbytes > LARGEST - 2**12:
        raise OSError(f"evidence of {numbers.nbytes:,} bytes on {lane.scheme}, at most {LARGEST:,}")
    content = BytesIO()
    # As `numpy.savez_compressed` writes them, which takes the sixth level: three times as long for 5 % less.
    with ZipFile(content, "w", ZIP_DEFLATED, compresslevel=1) as packed:
        for name, array in {"header": header, "numbers": numbers}.items():
            with packed.open(f"{name}.npy", "w") as part:
                np.lib.format.write_array(part, array, allow_pickle=False)
    return content.getvalue()


def unpack_lane(content: bytes) -> StoredLane | None:
    """Return the evidence that was packed; None if it is damaged, or was not packed by this program."""
    try:
        with ZipFile(BytesIO(content)) as packed:
            if sum(part.file_size for part in packed.infolist()) > LARGEST:
                raise ValueError("more than any evidence")
        with np.load(BytesIO(content), allow_pickle=False) as arrays:
            return _lane(json.loads(arrays["header"].tobytes()), arrays["numbers"])
    except (*FAULTS, BadZipFile, zlib.error):
        return None


def _place_record(record: MeasureRecord, arrays: list[Array]) -> dict[str, object]:
    sampled, probed = _place(record.sampled, arrays), _place(record.probed, arrays)
    return {"ingredients": dict(record.ingredients), "sampled": sampled, "probed": probed}


def _place(tally: Tally, arrays: list[Array]) -> dict[str, dict[str, tuple[int, ...]]]:
    """Put the numbers of a tally into a list and return the shapes of its arrays."""
    arrays += [np.asarray(value, dtype=float) for kind in KINDS for value in getattr(tally, kind).values()]
    return {kind: {name: np.shape(value) for name, value in getattr(tally, kind).items()} for kind in KINDS}


class _Numbers:
    """Numbers that are taken in the order in which they were put."""

    def __init__(self, numbers: Array) -> None:
        if numbers.dtype != float:
            raise ValueError("no numbers")
        self.numbers, self.taken = numbers, 0

    def take(self, shape: Sequence[int]) -> Array:
        """Return the next array."""
        if any(length < 0 for length in shape):
            raise ValueError("no shape")
        begin, self.taken = self.taken, self.taken + prod(shape)
        return self.numbers[begin : self.taken].reshape([int(length) for length in shape])

    def tally(self, told: Mapping[str, Mapping[str, Sequence[int]]]) -> Tally:
        """Return the next tally."""
        return Tally(*({str(name): self.take(shape) for name, shape in told[kind].items()} for kind in KINDS))


def _lane(told: dict[str, Any], found: Array) -> StoredLane:
    if told["format"] != FORMAT:
        raise ValueError("another format")
    numbers = _Numbers(found)
    health = numbers.tally(told["health"])
    records = {
        str(name): MeasureRecord(
            _texts(record["ingredients"]), numbers.tally(record["sampled"]), numbers.tally(record["probed"])
        )
        for name, record in told["measures"].items()
    }
    if numbers.taken != len(found):
        raise ValueError("other numbers than were told of")
    behaviour, opened = Behaviour(**_texts(told["behaviour"])), tuple(_texts(told["opened"]).items())
    known = behaviour, health, float(told["seconds"]), int(told["paths"]), records, opened
    return StoredLane(_texts(told["ingredients"]), *known)


def _texts(values: dict[str, Any]) -> Ingredients:
    return {str(name): str(value) for name, value in values.items()}


# Evidence on some measures of a scheme put together with that on its others.


def join_parts(entry: Entry, parts: Sequence[tuple[Entry, SchemeEvidence]]) -> SchemeEvidence:
    """Return the evidence on an entry from parts of its measures.

    Parameters
    ----------
    entry : Entry
    parts : sequence of (Entry, SchemeEvidence)
        Of the same scheme; together they have all its measures.
    """
    where = {m.name: (lane, index) for part, lane in parts for index, m in enumerate(part.measures)}
    found = [where[measure.name] for measure in entry.measures]
    lanes = [lane for _, lane in parts]
    did = list(dict.fromkeys(lane.behaviour for lane in lanes if lane.behaviour))
    return SchemeEvidence(
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
