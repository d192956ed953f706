"""The evidence of a run: what is on disk already, why the rest is not, where it goes, and how runs share it."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import blake2b
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import SCREENING
from ..contracts.specs import ProblemSpec
from ..contracts.tally import Tally
from ..errors import UsageError
from ..simulate.ensemble import Behaviour, Entry, SchemeEvidence, Task
from .behaviour import behaviours
from .code import Code
from .container import SUFFIX, Container, containers
from .files import data_opened, differing_files, opened_by
from .keys import (
    Files,
    Ingredients,
    describe_changes,
    differences,
    key,
    lane_codes,
    lane_files,
    lane_ingredients,
    measure_codes,
    measure_ingredients,
)
from .lanes import KINDS, MeasureRecord, StoredLane, fuller

FOLDER = "evidence"
NEW, DAMAGED, SOURCELESS = "not there yet", "damaged", "code without a source file"
EARLIER = "in files of an earlier version, which are not read"
AFRESH, UNTOLD = "asked for afresh", "of which nobody can tell what it does now"
# Tells what the schemes of a task do on its problem; None where that cannot be told.
Observe = Callable[[Task], Sequence[Behaviour | None]]
# Names may be as long as their authors like, names of files may not.
LONGEST_NAME = 60


class Place(NamedTuple):
    """Where the evidence of a scheme on a block goes, and what determines it; a worker process gets it.

    Attributes
    ----------
    container : Container
    name : str
        Of the lane in it.
    lane : mapping of str to str
    measures : mapping of str to (mapping of str to str)
        Without those whose source is unknown.
    files : mapping of str to (tuple of Path, str)
        Where the code of scheme and problem is, and a hash of what was read.
    replace : bool
        Whether what is there is replaced rather than added to.
    """

    container: Container
    name: str
    lane: Ingredients
    measures: Mapping[str, Ingredients]
    files: Files
    replace: bool = False


class Recalled(NamedTuple):
    """What the store knows of an entry of a task.

    Attributes
    ----------
    entry : Entry
        With the measures that `lane` is about.
    lane : SchemeEvidence or None
        None if nothing is known.
    missing : tuple of Measure
    place : Place or None
        Where the evidence on those goes; None if it cannot be kept.
    """

    entry: Entry
    lane: SchemeEvidence | None
    missing: tuple[Measure, ...]
    place: Place | None


class _Found(NamedTuple):
    """Where evidence goes, what is there, and why nothing is."""

    place: Place | None
    stored: StoredLane | None
    reason: str = ""


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

    def recall(self, task: Task, block: int, observe: Observe = behaviours) -> list[Recalled]:
        """Return what is known of each entry of a task on a block.

        Parameters
        ----------
        task : Task
        block : int
        observe : callable, Task -> sequence of (Behaviour or None), optional
            Asked where there is evidence, with its schemes: it is reused if they do the same now.
        """
        found = [self._look_up(task, block, entry) for entry in task.entries]
        doubtful = [entry for entry, (_, stored, _) in zip(task.entries, found, strict=True) if stored is not None]
        now = dict(zip(doubtful, observe(replace(task, entries=tuple(doubtful))), strict=True)) if doubtful else {}
        recalled = [self._recall(entry, *one, now.get(entry)) for entry, one in zip(task.entries, found, strict=True)]
        if used := [known.place for known in recalled if known.place is not None and not known.missing]:
            # What was used last counts where there is evidence of several versions: `compare` goes by that.
            used[0].container.mark_used(place.name for place in used)
        return recalled

    def lacking(self, task: Task, blocks: Iterable[int], observe: Observe = behaviours) -> set[tuple[Scheme, str]]:
        """Return of which scheme and measure not all evidence on some blocks is there; nothing is counted.

        Parameters
        ----------
        task : Task
            Schemes on a problem, with what is measured of each.
        blocks : iterable of int
        observe : callable, task -> Behaviours
            Tells what the schemes do, which is part of what evidence is kept under.
        """
        quiet = Store(self.folder)
        recalled = (known for block in blocks for known in quiet.recall(task, block, observe))
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

    def _look_up(self, task: Task, block: int, entry: Entry) -> "_Found":
        settings = task.settings if block == SCREENING else task.sampled
        lane = lane_ingredients(entry.scheme, task.spec, settings, block)
        if lane is None:
            return _Found(None, None, SOURCELESS)
        known = {measure.name: measure_ingredients(measure, task.settings) for measure in entry.measures}
        measures = {name: given for name, given in known.items() if given}
        container = Container(self.folder / FOLDER / f"{task.spec.name[:LONGEST_NAME]}{SUFFIX}")
        which = "step" if block == SCREENING else f"{block:04d}{_mark(task.stage)}"
        start = f"{which}-{_label_key(entry.scheme.label, task.spec.label)}-"
        files = lane_files(entry.scheme, task.spec)
        place = Place(container, f"{start}{key(lane)}", lane, measures, files, self.fresh)
        if self.fresh:
            return _Found(place, None, AFRESH)
        stored = container.lane(place.name)
        if stored is None or stored.ingredients != lane:
            return _Found(place, None, _why_not(place, start))
        if stored.opened and (changed := differing_files(stored.opened, _codes(entry, task.spec))):
            return _Found(place, None, f"with another {', '.join(changed)}")
        return _Found(place, stored)

    def _recall(
        self, entry: Entry, place: Place | None, stored: StoredLane | None, reason: str, now: Behaviour | None
    ) -> Recalled:
        if place is None or stored is None:
            return self._recall_nothing(entry, place, reason)
        if now is None:
            return self._recall_nothing(entry, place, UNTOLD)
        if now != stored.behaviour:
            return self._recall_nothing(entry, place, _otherwise(stored.behaviour, now))
        return self._recall_known(entry, place, stored)

    def _recall_nothing(self, entry: Entry, place: Place | None, reason: str) -> Recalled:
        self.reasons[reason] += 1
        return Recalled(Entry(entry.scheme, ()), None, entry.measures, place)

    def _recall_known(self, entry: Entry, place: Place, stored: StoredLane) -> Recalled:
        same = {n for n, record in stored.measures.items() if record.ingredients == place.measures.get(n)}
        known = tuple(measure for measure in entry.measures if measure.name in same)
        missing = tuple(measure for measure in entry.measures if measure.name not in same)
        if missing:
            changed = any(measure.name in stored.measures for measure in missing)
            self.reasons["of which a measure has changed" if changed else "to which a measure was added"] += 1
        else:
            self.reused += 1
        return Recalled(Entry(entry.scheme, known), _lane(stored, known), missing, place)


def _mark(stage: int) -> str:
    """Return how the name of evidence tells on which levels it is."""
    return "g" if stage < 0 else "f" * stage


def keep(places: Iterable[Place | None], entries: Sequence[Entry], lanes: Sequence[SchemeEvidence]) -> None:
    """Write the evidence of a block; what failed is not kept, so that it is tried again.

    Parameters
    ----------
    places : iterable of Place or None
        Where each scheme's evidence goes; None where it is not kept.
    entries : sequence of Entry
        The schemes, in the same order.
    lanes : sequence of SchemeEvidence
        What was found of them.

    Raises
    ------
    UsageError
        If it cannot be written, for example because the disk is full.
    """
    for place, entry, lane in zip(places, entries, lanes, strict=True):
        if place is not None and lane.behaviour is not None and not lane.violation:
            records = dict(_records(place, entry, lane))
            if records:
                known = (place.lane, lane.behaviour, lane.health, lane.seconds, lane.paths, records, lane.opened)
                _write(place, StoredLane(*known))


def with_opened(lanes: Iterable[SchemeEvidence], task: Task) -> tuple[SchemeEvidence, ...]:
    """Return the evidence on the entries of a task with the files that their code has opened in this process."""
    measures = (type(measure) for entry in task.entries for measure in entry.measures)
    if not data_opened([task.spec.function, *(type(entry.scheme) for entry in task.entries), *measures]):
        return tuple(lanes)
    pairs = zip(lanes, task.entries, strict=True)
    return tuple(lane._replace(opened=opened_by(_codes(entry, task.spec))) for lane, entry in pairs)


def _codes(entry: Entry, spec: ProblemSpec) -> list[Code | None]:
    return [*lane_codes(entry.scheme, spec).values(), *measure_codes(entry.measures)]


def describe_saved(place: Place | None) -> str:
    """Return in words what was saved since evidence was planned, as a worker process finds it; empty if nothing."""
    return describe_changes(place.files) if place is not None else ""


def _write(place: Place, lane: StoredLane) -> None:
    try:
        place.container.write(place.name, lambda before: lane if place.replace else _add(before, lane))
    except OSError as error:
        raise UsageError(
            f"cannot write {place.container.path}: {error.strerror or error}; choose another --out"
        ) from error


def _add(before: StoredLane | None, lane: StoredLane) -> StoredLane:
    """Return evidence with that on measures that were kept before, as far as the same code made it."""
    if before is None or (before.ingredients, before.behaviour) != (lane.ingredients, lane.behaviour):
        return lane
    if {**dict(before.opened), **dict(lane.opened)} != {**dict(lane.opened), **dict(before.opened)}:
        return lane
    others = {name: record for name, record in before.measures.items() if name not in lane.measures}
    health, seconds = fuller(lane.health, before.health), lane.seconds + before.seconds
    opened = tuple(sorted({*before.opened, *lane.opened}))
    return lane._replace(health=health, seconds=seconds, measures={**others, **lane.measures}, opened=opened)


def _records(place: Place, entry: Entry, lane: SchemeEvidence) -> Iterable[tuple[str, MeasureRecord]]:
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


def _otherwise(before: Behaviour, now: Behaviour) -> str:
    names = [name for name in Behaviour._fields if getattr(before, name) != getattr(now, name)]
    return f"with another behaviour of the {' and of the '.join(names)}"


def _why_not(place: Place, start: str) -> str:
    """Return what differs from the evidence on the same scheme, problem and block that was used last."""
    found = place.container.newest(start)
    if found is None:
        earlier = place.container.path.with_suffix("")
        return EARLIER if next(earlier.glob("*/*.npz"), None) else NEW
    name, old = found
    if old is None or name == place.name:
        return DAMAGED
    return f"with another {', '.join(differences(old.ingredients, place.lane))}"


def _label_key(scheme: str, problem: str) -> str:
    return blake2b(f"{scheme}\0{problem}".encode(), digest_size=6).hexdigest()


class Copied(NamedTuple):
    """On how many lanes evidence was copied, was there already, was there with other numbers, or is damaged."""

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
    for container in containers(source / FOLDER):
        place = Container(target / FOLDER / container.path.name)
        try:
            for name, lane in container.lanes():
                kind = "damaged" if lane is None else _copy_lane(name, lane, place)
                counts = counts._replace(**{kind: getattr(counts, kind) + 1})
        except OSError as error:
            reason = error.strerror or error
            raise UsageError(f"cannot write {place.path}: {reason}; choose another --out") from error
    return counts


def _copy_lane(name: str, lane: StoredLane, place: Container) -> str:
    there = place.lane(name)
    if there is None:
        place.write(name, lambda _: lane)
        return "new"
    added = {name: record for name, record in lane.measures.items() if name not in there.measures}
    if added:
        place.write(name, lambda _: there._replace(measures={**there.measures, **added}))
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
