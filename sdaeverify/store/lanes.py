"""Evidence on a lane as bytes: a header in JSON and numbered arrays; reading them executes nothing.

All is packed as one stream. Arrays of a kind lie one behind the other, and of all their numbers first the first
bytes, then the second ones, and so on: signs, exponents and digits that are zero pack well, the others do not at all.
What unpacks to more than any evidence takes is refused, so that a file from elsewhere cannot fill the memory.
"""

import json
import zlib
from collections.abc import Mapping, Sequence
from functools import reduce
from math import prod
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..contracts.tally import Tally
from ..errors import FAULTS
from ..simulate.ensemble import Behaviour, Entry, SchemeEvidence
from .behaviour import differing
from .files import Opened
from .keys import Ingredients

FORMAT = 4
KINDS = ("sums", "maxima", "largest")
# Kinds of arrays that evidence is made of: truth values, whole numbers, numbers.
NUMBERS = "biuf"
# Bytes of the header's length, and of all that is unpacked.
LENGTH, LARGEST = 8, 2**28


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
    places = _header(lane, arrays)
    kinds = list(dict.fromkeys(array.dtype.str for array in arrays))
    header = json.dumps({**places, "arrays": [[array.dtype.str, *array.shape] for array in arrays]}).encode()
    planes = [_planes([array for array in arrays if array.dtype.str == kind]) for kind in kinds]
    whole = b"".join([len(header).to_bytes(LENGTH), header, *planes])
    if len(whole) > LARGEST:
        raise OSError(f"evidence of {len(whole):,} bytes on {lane.scheme}, at most {LARGEST:,}")
    # In half the time of the default level, by a twentieth more: most of it is digits that pack at no level.
    return zlib.compress(whole, 1)


def unpack_lane(content: bytes) -> StoredLane | None:
    """Return the evidence that was packed; None if it is damaged, or was not packed by this program."""
    try:
        stream = zlib.decompressobj()
        whole = stream.decompress(content, LARGEST)
        if not stream.eof:
            raise ValueError("more than any evidence, or cut short")
        end = LENGTH + int.from_bytes(whole[:LENGTH])
        header = _read_header(whole[LENGTH:end])
        return _lane(header, _arrays(header["arrays"], whole[end:]))
    except (*FAULTS, zlib.error):
        return None


def _header(lane: StoredLane, arrays: list[Array]) -> dict[str, object]:
    return {
        "format": FORMAT,
        "ingredients": dict(lane.ingredients),
        "behaviour": lane.behaviour._asdict(),
        "opened": dict(lane.opened),
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


def _planes(arrays: Sequence[Array]) -> bytes:
    """Return arrays of one kind as bytes: the first bytes of all numbers, then the second ones, and so on."""
    numbers = np.concatenate([array.ravel() for array in arrays])
    return numbers.view(np.uint8).reshape(-1, numbers.itemsize).T.tobytes()


def _arrays(told: Sequence[Sequence[Any]], planes: bytes) -> list[Array]:
    """Return the arrays that were told of, with all bytes used."""
    kinds = [np.dtype(kind) for kind, *_ in told]
    if any(kind.kind not in NUMBERS for kind in kinds):
        raise ValueError("no numbers")
    shapes = [tuple(int(length) for length in shape) for _, *shape in told]
    if any(length < 0 for shape in shapes for length in shape):
        raise ValueError("no shape")
    found: dict[int, Array] = {}
    for kind in dict.fromkeys(kinds):
        chosen = [index for index, other in enumerate(kinds) if other == kind]
        lengths = [prod(shapes[index]) for index in chosen]
        size = kind.itemsize * sum(lengths)
        numbers, planes = _numbers(planes[:size], kind, sum(lengths)), planes[size:]
        parts = np.split(numbers, np.cumsum(lengths)[:-1])
        found |= {index: part.reshape(shapes[index]) for index, part in zip(chosen, parts, strict=True)}
    if planes:
        raise ValueError("more than was told of")
    return [found[index] for index in range(len(told))]


def _numbers(planes: bytes, kind: np.dtype[Any], count: int) -> Array:
    columns = np.frombuffer(planes, dtype=np.uint8).reshape(kind.itemsize, count).T
    return np.ascontiguousarray(columns).view(kind).reshape(count)


def _read_header(content: bytes) -> dict[str, Any]:
    header: dict[str, Any] = json.loads(content)
    if header["format"] != FORMAT:
        raise ValueError("another format")
    return header


def _lane(header: dict[str, Any], arrays: Sequence[Array]) -> StoredLane:
    records = {
        str(name): MeasureRecord(
            _texts(record["ingredients"]), _tally(record["sampled"], arrays), _tally(record["probed"], arrays)
        )
        for name, record in header["measures"].items()
    }
    health, behaviour = _tally(header["health"], arrays), Behaviour(**_texts(header["behaviour"]))
    seconds, paths = float(header["seconds"]), int(header["paths"])
    opened = tuple(_texts(header["opened"]).items())
    return StoredLane(_texts(header["ingredients"]), behaviour, health, seconds, paths, records, opened)


def _tally(places: dict[str, dict[str, int]], arrays: Sequence[Array]) -> Tally:
    return Tally(*({str(name): arrays[int(at)] for name, at in places[kind].items()} for kind in KINDS))


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
        opened=tuple(sorted({file for lane in lanes for file in lane.opened})),
    )


def fuller(a: Tally, b: Tally) -> Tally:
    """Return the health that counts more steps: a lane that only evaluates the one-step map makes none."""
    return b if _steps(b) > _steps(a) else a


def _steps(health: Tally) -> float:
    return float(health.sums["steps"].sum()) if "steps" in health.sums else -1.0
