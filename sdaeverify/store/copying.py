"""Evidence of one folder taken over into another."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..contracts.tally import Tally
from ..errors import UsageError
from .atomic import written
from .files import KINDS, MeasureRecord, StoredLane, read_lane, write_lane
from .store import FOLDER


class Copied(NamedTuple):
    """How many files were copied, were there already, were there with other numbers, or are damaged."""

    new: int = 0
    same: int = 0
    other: int = 0
    damaged: int = 0


def copy_evidence(source: Path, target: Path) -> Copied:
    """Copy the evidence of a run into another run's folder; of numbers that differ, those that are there stay.

    Parameters
    ----------
    source, target : Path
        Folders of reports.

    Returns
    -------
    Copied

    Raises
    ------
    UsageError
        If it cannot be written, for example because the disk is full.
    """
    counts = Copied()
    for file in sorted((source / FOLDER).rglob("*.npz")):
        place = target / FOLDER / file.relative_to(source / FOLDER)
        try:
            kind = _copied(file, place)
        except OSError as error:
            raise UsageError(f"cannot write {place}: {error.strerror or error}; choose another --out") from error
        counts = counts._replace(**{kind: getattr(counts, kind) + 1})
    return counts


def _copied(file: Path, place: Path) -> str:
    lane, there = read_lane(file), read_lane(place)
    if lane is None:
        return "damaged"
    if there is None:
        place.parent.mkdir(parents=True, exist_ok=True)
        with written(place) as copy:
            copy.write(file.read_bytes())
        return "new"
    added = {name: record for name, record in lane.measures.items() if name not in there.measures}
    if added:
        write_lane(there._replace(measures={**there.measures, **added}), place)
    return "same" if _agree(lane, there) else "other"


def _agree(one: StoredLane, other: StoredLane) -> bool:
    pairs = ((one.measures[name], other.measures[name]) for name in one.measures if name in other.measures)
    return all(_equal(a, b) for a, b in pairs)


def _equal(a: MeasureRecord, b: MeasureRecord) -> bool:
    return a.ingredients != b.ingredients or (_same(a.sampled, b.sampled) and _same(a.probed, b.probed))


def _same(a: Tally, b: Tally) -> bool:
    return all(
        getattr(a, kind).keys() == getattr(b, kind).keys()
        and all(np.array_equal(x, getattr(b, kind)[name], equal_nan=True) for name, x in getattr(a, kind).items())
        for kind in KINDS
    )
