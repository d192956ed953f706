"""The evidence of a run: what of it is on disk already, why the rest is not, and where it goes."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path
from typing import NamedTuple

from ..ensemble import Entry, LaneEvidence, Task
from ..errors import UsageError
from ..measure import Measure
from ..scheme import Scheme
from .files import MeasureRecord, StoredLane, read_ingredients, read_lane, write_lane
from .keys import Ingredients, differences, key, lane_ingredients, measure_ingredients
from .parts import fuller

FOLDER = "evidence"
NEW, DAMAGED, SOURCELESS = "not there yet", "damaged", "code without a source file"
# Names may be as long as their authors like, names of files may not.
LONGEST_NAME = 60


class Place(NamedTuple):
    """Where the evidence of a scheme on a block goes, and what determines it; a worker process gets it.

    Attributes
    ----------
    path : Path
    lane : mapping of str to str
    measures : mapping of str to (mapping of str to str)
        Without those whose source is unknown.
    replace : bool
        Whether what is there is replaced rather than added to.
    """

    path: Path
    lane: Ingredients
    measures: Mapping[str, Ingredients]
    replace: bool = False


class Recalled(NamedTuple):
    """What the store knows of an entry of a task.

    Attributes
    ----------
    entry : Entry
        With the measures that `lane` is about.
    lane : LaneEvidence or None
        None if nothing is known.
    missing : tuple of Measure
    place : Place or None
        Where the evidence on those goes; None if it cannot be kept.
    """

    entry: Entry
    lane: LaneEvidence | None
    missing: tuple[Measure, ...]
    place: Place | None


@dataclass
class Store:
    """Evidence in a folder.

    Parameters
    ----------
    folder : Path
        Of the report; evidence lies below it.
    fresh : bool
        Whether what is there is left unread, and replaced.

    Attributes
    ----------
    reused : int
        Blocks of a scheme that were found.
    reasons : Counter of str
        Why the others were not, in words.
    """

    folder: Path
    fresh: bool = False
    reused: int = 0
    reasons: Counter[str] = field(default_factory=Counter)

    def recall(self, task: Task, block: int) -> list[Recalled]:
        """Return what is known of each entry of a task on a block."""
        return [self._recall(task, block, entry) for entry in task.entries]

    def lacking(self, task: Task, blocks: Iterable[int]) -> set[tuple[Scheme, str]]:
        """Return of which scheme and measure not all evidence on some blocks is there; nothing is counted."""
        quiet = Store(self.folder)
        recalled = (known for block in blocks for known in quiet.recall(task, block))
        return {(known.entry.scheme, measure.name) for known in recalled for measure in known.missing}

    @property
    def telling(self) -> bool:
        """Whether anything was found at all, of use or not."""
        return bool(self.reused or set(self.reasons) - {NEW, SOURCELESS})

    def summary(self) -> str:
        """Return in words how much was reused, and why the rest was not."""
        new = sum(self.reasons.values())
        words = [f"{count} {reason}" for reason, count in sorted(self.reasons.items(), key=lambda pair: -pair[1])]
        computed = f"; computed: {', '.join(words)}" if words else ""
        return f"evidence of {self.reused} of {self.reused + new} blocks of paths was reused{computed}"

    def _recall(self, task: Task, block: int, entry: Entry) -> Recalled:
        lane = lane_ingredients(entry.scheme, task.spec, task.settings, block)
        if lane is None:
            return self._unknown(entry, None, SOURCELESS)
        found = {measure.name: measure_ingredients(measure, task.settings) for measure in entry.measures}
        measures = {name: given for name, given in found.items() if given}
        names = self.folder / FOLDER / task.spec.name[:LONGEST_NAME] / entry.scheme.name[:LONGEST_NAME]
        start = f"{block:04d}-{_label_key(entry.scheme.label, task.spec.label)}-"
        place = Place(names / f"{start}{key(lane)}.npz", lane, measures, self.fresh)
        if self.fresh:
            return self._unknown(entry, place, "asked for afresh")
        stored = read_lane(place.path)
        if stored is None or stored.ingredients != place.lane:
            return self._unknown(entry, place, _why_not(place, start))
        return self._known(entry, place, stored)

    def _unknown(self, entry: Entry, place: Place | None, reason: str) -> Recalled:
        self.reasons[reason] += 1
        return Recalled(Entry(entry.scheme, ()), None, entry.measures, place)

    def _known(self, entry: Entry, place: Place, stored: StoredLane) -> Recalled:
        same = {n for n, record in stored.measures.items() if record.ingredients == place.measures.get(n)}
        known = tuple(measure for measure in entry.measures if measure.name in same)
        missing = tuple(measure for measure in entry.measures if measure.name not in same)
        if missing:
            changed = any(measure.name in stored.measures for measure in missing)
            self.reasons["of which a measure has changed" if changed else "to which a measure was added"] += 1
        else:
            self.reused += 1
            # The newest file is the one that was used last: `compare` goes by that.
            with suppress(OSError):
                place.path.touch()
        return Recalled(Entry(entry.scheme, known), _lane(stored, known), missing, place)


def keep(places: Iterable[Place | None], entries: Sequence[Entry], lanes: Sequence[LaneEvidence]) -> None:
    """Write the evidence of a block; what failed is not kept, so that it is tried again.

    Raises
    ------
    UsageError
        If it cannot be written, for example because the disk is full.
    """
    for place, entry, lane in zip(places, entries, lanes, strict=True):
        if place is not None and not lane.breach:
            records = dict(_records(place, entry, lane))
            if records:
                _write(place, StoredLane(place.lane, lane.health, lane.seconds, lane.paths, records))


def _write(place: Place, lane: StoredLane) -> None:
    try:
        before = None if place.replace else read_lane(place.path)
        if before is not None and before.ingredients == place.lane:
            # Measures that were kept before stay, as far as this program knows what determines them.
            others = {name: record for name, record in before.measures.items() if name not in lane.measures}
            health, seconds = fuller(lane.health, before.health), lane.seconds + before.seconds
            lane = lane._replace(health=health, seconds=seconds, measures={**others, **lane.measures})
        write_lane(lane, place.path)
    except OSError as error:
        raise UsageError(f"cannot write {place.path}: {error.strerror or error}; choose another --out") from error


def _records(place: Place, entry: Entry, lane: LaneEvidence) -> Iterable[tuple[str, MeasureRecord]]:
    for index, measure in enumerate(entry.measures):
        if measure.name in place.measures and not lane.errors[index]:
            own = place.measures[measure.name]
            yield measure.name, MeasureRecord(own, lane.tallies[index], lane.probes[index])


def _lane(stored: StoredLane, measures: Sequence[Measure]) -> LaneEvidence | None:
    if not measures:
        return None
    records = [stored.measures[measure.name] for measure in measures]
    sampled, probed = tuple(r.sampled for r in records), tuple(r.probed for r in records)
    return LaneEvidence(sampled, probed, stored.health, stored.seconds, tuple("" for _ in records), stored.paths)


def _why_not(place: Place, start: str) -> str:
    """Return what differs from the newest file of the same scheme, problem and block."""
    others = sorted(place.path.parent.glob(f"{start}*.npz"), key=lambda path: path.stat().st_mtime)
    if not others:
        return NEW
    old = read_ingredients(others[-1])
    if old is None or others[-1] == place.path:
        return DAMAGED
    return f"with another {', '.join(differences(old, place.lane))}"


def _label_key(scheme: str, problem: str) -> str:
    return blake2b(f"{scheme}\0{problem}".encode(), digest_size=6).hexdigest()
