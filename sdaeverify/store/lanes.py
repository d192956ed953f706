"""Serialisation of the evidence on a lane: a header in JSON, and the numbers of all arrays in NumPy's format.

Reading executes no code. Content that unpacks to more than `LARGEST` bytes is refused, so that a foreign file
cannot exhaust the memory.
"""

import zlib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from functools import reduce
from io import BytesIO
from math import prod
from typing import NamedTuple
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile

import msgspec
import numpy as np

from ..arrays import Array
from ..contracts.tally import Tally
from ..errors import FAULTS
from ..simulate.ensemble import Behaviour, Entry, SchemeEvidence
from .behaviour import differing
from .files import Opened
from .keys import Ingredients

FORMAT = 6
# Maximum number of bytes after unpacking.
LARGEST = 2**28


class MeasureRecord(NamedTuple):
    """Evidence of one measure, and its ingredients in addition to those of the lane."""

    ingredients: Ingredients
    sampled: Tally
    probed: Tally


class StoredLane(NamedTuple):
    """Evidence on a scheme from one block of paths of a problem.

    Attributes
    ----------
    ingredients : mapping of str to str
        See `lane_ingredients`; ``scheme``, ``problem`` and ``index`` identify the lane.
    behaviour : Behaviour
        Digests of the results of scheme and problem.
    health : Tally
    seconds : float
    paths : int
    measures : mapping of str to MeasureRecord
    opened : tuple of (str, str)
        Files that its code had opened, with hashes of their contents.
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
    """Serialise evidence.

    Raises
    ------
    OSError
        If it is larger than `unpack_lane` accepts.
    """
    arrays = [np.zeros(0)]

    def place(array: Array) -> tuple[int, ...]:
        arrays.append(np.asarray(array, dtype=float).ravel())
        return array.shape

    # A copy of a tally contains its numbers only, without cached readings.
    header = np.frombuffer(msgspec.json.encode((FORMAT, deepcopy(lane)), enc_hook=place), dtype=np.uint8)
    numbers = np.concatenate(arrays)
    if header.nbytes + numbers.nbytes > LARGEST - 2**12:
        raise OSError(f"evidence of {numbers.nbytes:,} bytes on {lane.scheme}, at most {LARGEST:,}")
    content = BytesIO()
    # The format of `numpy.savez_compressed`, but at level 1: its level 6 takes three times as long for 5 % less.
    parts: dict[str, Array] = {"header": header, "numbers": numbers}
    with ZipFile(content, "w", ZIP_DEFLATED, compresslevel=1) as packed:
        for name, array in parts.items():
            with packed.open(f"{name}.npy", "w") as part:
                np.lib.format.write_array(part, array, allow_pickle=False)
    return content.getvalue()


def unpack_lane(content: bytes) -> StoredLane | None:
    """Deserialise evidence; return None if it is damaged or has another format."""
    try:
        with ZipFile(BytesIO(content)) as packed:
            if sum(part.file_size for part in packed.infolist()) > LARGEST:
                raise ValueError("more than any evidence")
        with np.load(BytesIO(content), allow_pickle=False) as arrays:
            return _lane(arrays["header"].tobytes(), arrays["numbers"])
    except (*FAULTS, BadZipFile, zlib.error):
        return None


def _lane(header: bytes, numbers: Array) -> StoredLane:
    if numbers.dtype != float:
        raise ValueError("no numbers")
    taken = 0

    def take(_: type, shape: Sequence[int]) -> Array:
        """Return the next array; arrays are stored in the order of the header."""
        nonlocal taken
        if any(length < 0 for length in shape):
            raise ValueError("no shape")
        begin, taken = taken, taken + prod(shape)
        return numbers[begin:taken].reshape(shape)

    written, lane = msgspec.json.decode(header, type=tuple[int, StoredLane], dec_hook=take)
    if written != FORMAT or taken != len(numbers):
        raise ValueError("another format, or other numbers than were told of")
    return lane


# Merging of evidence on different measures of one scheme.


def join_parts(entry: Entry, parts: Sequence[tuple[Entry, SchemeEvidence]]) -> SchemeEvidence:
    """Merge evidence on disjoint sets of an entry's measures.

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
    """Return the health that counts more steps; a lane that only evaluates the one-step map makes none."""
    return b if _steps(b) > _steps(a) else a


def _steps(health: Tally) -> float:
    return float(health.sums["steps"].sum()) if "steps" in health.sums else -1.0
