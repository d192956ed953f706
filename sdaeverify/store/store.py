"""The evidence of a run: lookup on disk, reasons for recomputation, storage, and copying between runs."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.stages import SCREENING
from ..simulate.ensemble import Behaviour, Entry, SchemeEvidence, Task
from .behaviour import behaviours, changed_parts
from .code import homes_of
from .container import SUFFIX, Change, all_lanes, containers, read_lanes, write_lanes
from .files import differing_files, opened_by
from .keys import Ingredients, key, lane_ingredients, measure_ingredients
from .lanes import MeasureRecord, StoredLane, fuller

FOLDER = "evidence"
NEW, DAMAGED, SOURCELESS = "without stored evidence", "damaged or of another version", "code without a source file"
AFRESH, UNTOLD = "on request", "whose present behaviour is unknown"
ADDED, CHANGED = "to which a measure was added", "of which a measure has changed"
# Returns the behaviour of each scheme of a task on its problem; None where it cannot be determined.
Observe = Callable[[Task], Sequence[Behaviour | None]]
# File names are truncated, because names of problems may be longer than file systems allow.
LONGEST_NAME = 60


class Place(NamedTuple):
    """Destination of the evidence of a scheme on a block, with its ingredients; it is sent to worker processes.

    Attributes
    ----------
    path : Path
        Of the file.
    name : str
        Of the lane in the file.
    lane : mapping of str to str
        Ingredients of the lane.
    measures : mapping of str to (mapping of str to str)
        Ingredients of each measure; measures without source code are omitted.
    replace : bool
        Whether stored evidence is replaced rather than extended.
    """

    path: Path
    name: str
    lane: Ingredients
    measures: Mapping[str, Ingredients]
    replace: bool = False


class Recalled(NamedTuple):
    """Stored evidence on an entry of a task.

    Attributes
    ----------
    entry : Entry
        With the measures whose evidence is in `lane`.
    lane : SchemeEvidence or None
        None if there is no stored evidence.
    missing : tuple of Measure
        Measures without stored evidence.
    place : Place or None
        Destination of the missing evidence; None if it cannot be stored.
    """

    entry: Entry
    lane: SchemeEvidence | None
    missing: tuple[Measure, ...]
    place: Place | None


@dataclass
class Store:
    """Evidence in a folder.

    Parameters
    ----------
    folder : Path
        Of the report; evidence is in a subfolder.
    fresh : bool
        Whether stored evidence is ignored, and replaced.

    Attributes
    ----------
    reused : int
        Number of lanes (blocks of a scheme) whose evidence was reused.
    reused_findings : int
        Number of pairs of a scheme and a class of equations whose findings were reused.
    reasons : Counter of str
        Number of other lanes by the reason why they were not.
    """

    folder: Path
    fresh: bool = False
    reused: int = 0
    reused_findings: int = 0
    reasons: Counter[str] = field(default_factory=Counter)

    def recall(self, task: Task, block: int, observe: Observe = behaviours) -> list[Recalled]:
        """Return the stored evidence on each entry of a task for a block.

        Parameters
        ----------
        task : Task
        block : int
        observe : callable, Task -> sequence of (Behaviour or None), optional
            Called with the schemes that have stored evidence, which is reused only if their behaviour is unchanged.
        """
        places = [self._place(task, block, entry) for entry in task.entries]
        names = [] if self.fresh else [place.name for place in places if place is not None]
        there = read_lanes(self._file(task), names)
        found = [self._look_up(place, there, task, entry) for place, entry in zip(places, task.entries, strict=True)]
        doubtful = [e for e, stored in zip(task.entries, found, strict=True) if isinstance(stored, StoredLane)]
        now = dict(zip(doubtful, observe(replace(task, entries=tuple(doubtful))), strict=True)) if doubtful else {}
        known = zip(task.entries, places, found, strict=True)
        return [self._recall(entry, place, stored, now.get(entry)) for entry, place, stored in known]

    def lacking(self, task: Task, blocks: Iterable[int], observe: Observe = behaviours) -> set[tuple[Scheme, str]]:
        """Return the pairs of scheme and measure with incomplete evidence on some blocks; counters are not updated.

        Parameters
        ----------
        task : Task
            Schemes on a problem, with the measures of each.
        blocks : iterable of int
        observe : callable, Task -> sequence of (Behaviour or None), optional
            Returns the behaviour of the schemes, which must equal that of the stored evidence.
        """
        quiet = Store(self.folder)
        recalled = (known for block in blocks for known in quiet.recall(task, block, observe))
        return {(known.entry.scheme, measure.name) for known in recalled for measure in known.missing}

    @property
    def telling(self) -> bool:
        """Whether any stored evidence was found, usable or not."""
        return bool(self.reused or set(self.reasons) - {NEW, SOURCELESS})

    def summary(self) -> str:
        """Return a text with the share of reused evidence, and the reasons for the rest."""
        new = sum(self.reasons.values())
        words = [f"{count} {reason}" for reason, count in sorted(self.reasons.items(), key=lambda pair: -pair[1])]
        computed = f"; the others were computed: {', '.join(words)}" if words else ""
        if self.reused_findings:
            computed = f", and the findings of {self.reused_findings} tests on classes of equations{computed}"
        share = f"{self.reused} of {self.reused + new}"
        return f"evidence of {share} blocks of paths, controls included, was reused{computed}"

    def _file(self, task: Task) -> Path:
        return self.folder / FOLDER / f"{task.spec.name[:LONGEST_NAME]}{SUFFIX}"

    def _place(self, task: Task, block: int, entry: Entry) -> Place | None:
        settings = task.settings if block == SCREENING else task.sampled
        lane = lane_ingredients(entry.scheme, task.spec, settings, block, task.followed)
        if lane is None:
            return None
        known = {measure.name: measure_ingredients(measure, task.settings) for measure in entry.measures}
        measures = {name: given for name, given in known.items() if given}
        return Place(self._file(task), key(lane), lane, measures, self.fresh)

    def _look_up(
        self, place: Place | None, there: Mapping[str, StoredLane | None], task: Task, entry: Entry
    ) -> StoredLane | str:
        """Return the stored evidence, or the reason why it cannot be used."""
        if place is None or self.fresh:
            return SOURCELESS if place is None else AFRESH
        stored = there.get(place.name)
        if stored is None:
            return DAMAGED if place.name in there else NEW
        changed = [name for name, value in place.lane.items() if stored.ingredients.get(name) != value]
        if not changed and stored.opened:
            changed = differing_files(stored.opened, _homes(entry, task))
        return f"with another {', '.join(changed)}" if changed else stored

    def _recall(self, entry: Entry, place: Place | None, stored: StoredLane | str, now: Behaviour | None) -> Recalled:
        if isinstance(stored, str) or now != stored.behaviour or place is None:
            self.reasons[stored if isinstance(stored, str) else _otherwise(stored.behaviour, now)] += 1
            return Recalled(Entry(entry.scheme, ()), None, entry.measures, place)
        same = {n for n, record in stored.measures.items() if record.ingredients == place.measures.get(n)}
        known = tuple(measure for measure in entry.measures if measure.name in same)
        missing = tuple(measure for measure in entry.measures if measure.name not in same)
        if missing:
            self.reasons[CHANGED if any(measure.name in stored.measures for measure in missing) else ADDED] += 1
        else:
            self.reused += 1
        return Recalled(Entry(entry.scheme, known), _lane(stored, known), missing, place)


# By the label of the scheme; None if its evidence is not stored.
Places = Mapping[str, Place | None]


def keep(places: Places, entries: Sequence[Entry], lanes: Sequence[SchemeEvidence]) -> None:
    """Write the evidence of a block; failed evidence is not stored, so that it is tried again.

    Parameters
    ----------
    places : mapping of str to (Place or None)
        Destination of each scheme's evidence, by its label.
    entries : sequence of Entry
    lanes : sequence of SchemeEvidence
        Evidence on each entry.

    Raises
    ------
    UsageError
        If a file cannot be written, for example because the disk is full.
    """
    changes: dict[Path, dict[str, Change]] = defaultdict(dict)
    for entry, lane in zip(entries, lanes, strict=True):
        place = places.get(entry.scheme.label)
        if place is None or lane.behaviour is None or lane.violation:
            continue
        if records := dict(_records(place, entry, lane)):
            known = (place.lane, lane.behaviour, lane.health, lane.seconds, lane.paths, records, lane.opened)
            changes[place.path][place.name] = partial(_replace if place.replace else _add, StoredLane(*known))
    for path, changed in changes.items():
        write_lanes(path, changed)


def with_opened(lanes: Iterable[SchemeEvidence], task: Task) -> tuple[SchemeEvidence, ...]:
    """Return the evidence on the entries of a task with the files that their code has opened in this process."""
    homes = [_homes(entry, task) for entry in task.entries]
    # Compute once per package: most schemes of a task come from the same one.
    opened = {each: opened_by(each) for each in set(homes)}
    return tuple(lane._replace(opened=opened[each]) for lane, each in zip(lanes, homes, strict=True))


def _homes(entry: Entry, task: Task) -> frozenset[Path]:
    """Return the top-level packages and files that contain the code of a scheme, its problem and its measures."""
    things = type(entry.scheme), task.spec.function, *map(type, entry.measures)
    return frozenset(home for thing in things for home in homes_of(thing) if home is not None)


def _replace(lane: StoredLane, _: StoredLane | None) -> StoredLane:
    return lane


def _add(lane: StoredLane, before: StoredLane | None) -> StoredLane:
    """Return evidence extended by that on other measures, if it has the same ingredients, behaviour and files."""
    if before is None or (before.ingredients, before.behaviour) != (lane.ingredients, lane.behaviour):
        return lane
    opened = dict(before.opened) | dict(lane.opened)
    others = {name: record for name, record in before.measures.items() if name not in lane.measures}
    if not others or opened != dict(lane.opened) | dict(before.opened):
        return lane
    health, seconds = fuller(lane.health, before.health), lane.seconds + before.seconds
    measures = {**others, **lane.measures}
    return lane._replace(health=health, seconds=seconds, measures=measures, opened=tuple(sorted(opened.items())))


def _records(place: Place, entry: Entry, lane: SchemeEvidence) -> Iterator[tuple[str, MeasureRecord]]:
    for index, measure in enumerate(entry.measures):
        if measure.name in place.measures and not lane.errors[index]:
            own = place.measures[measure.name]
            yield measure.name, MeasureRecord(own, lane.tallies[index], lane.probes[index])


def _lane(stored: StoredLane, measures: Sequence[Measure]) -> SchemeEvidence | None:
    if not measures:
        return None
    records = [stored.measures[measure.name] for measure in measures]
    sampled, probed = tuple(r.sampled for r in records), tuple(r.probed for r in records)
    lane = SchemeEvidence(sampled, probed, stored.health, stored.seconds, tuple("" for _ in records), stored.paths)
    return lane._replace(behaviour=stored.behaviour, opened=stored.opened)


def _otherwise(before: Behaviour, now: Behaviour | None) -> str:
    names = changed_parts(before, now)
    return f"with another behaviour of the {' and of the '.join(names)}" if names else UNTOLD


def copy_evidence(source: Path, target: Path) -> Counter[str]:
    """Copy the evidence of a run into another run's folder; where numbers differ, the target's are kept.

    Parameters
    ----------
    source, target : Path
        Folders of reports.

    Returns
    -------
    Counter of str
        Number of lanes that are "new", have the "same" or "other" numbers in the target, or are "damaged".

    Raises
    ------
    UsageError
        If a file cannot be written, for example because the disk is full.
    """
    counts: Counter[str] = Counter()
    for path in containers(source / FOLDER):
        for name, lane in all_lanes(path):
            counts["damaged" if lane is None else _copy_lane(name, lane, target / FOLDER / path.name)] += 1
    return counts


def _copy_lane(name: str, lane: StoredLane, path: Path) -> str:
    there = read_lanes(path, [name]).get(name)
    if there is None or there.ingredients != lane.ingredients:
        write_lanes(path, {name: partial(_replace, lane)})
        return "new"
    if (both := _add(there, lane)) is not there:
        write_lanes(path, {name: partial(_replace, both)})
    shared = [name for name in lane.measures if name in there.measures]
    return "same" if all(_agree(lane.measures[name], there.measures[name]) for name in shared) else "other"


def _agree(a: MeasureRecord, b: MeasureRecord) -> bool:
    """Return whether two records have the same numbers; True if different code made them."""
    same = [np.array_equal(x, y, equal_nan=True) for x, y in zip(_arrays(a), _arrays(b), strict=False)]
    return a.ingredients != b.ingredients or all(same)


def _arrays(record: MeasureRecord) -> list[Array]:
    tallies = record.sampled, record.probed
    kinds = (kind for tally in tallies for kind in (tally.sums, tally.maxima, tally.largest))
    return [kind[name] for kind in kinds for name in sorted(kind)]
