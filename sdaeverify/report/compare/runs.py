"""The stored evidence of a run with its settings, or the reason why there is none to compare."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from ...contracts.settings import SCREENING, Settings
from ...contracts.spelling import counted
from ...errors import UsageError
from ...store.container import all_lanes, containers
from ...store.lanes import StoredLane
from ...store.store import FOLDER
from ..cells import number
from ..folders import LEVELS, Key, TextRow, key_of, read_table, read_tables, read_verdicts, run_of
from ..saved import SavedRun
from ..saved import read_run as read_saved
from ..tables.choice import Leading

# Settings that determine the noise and the step sizes.
COMMON = ("seed", "coarsest", "levels", "block")
FINGERPRINT = "stream_fingerprint"

Lanes = Mapping[int, StoredLane]


@dataclass(frozen=True)
class StoredRun:
    """The evidence of a run.

    Attributes
    ----------
    saved : SavedRun
    fingerprint : str
        Fingerprint of the stream of noise.
    lanes : mapping of (str, str) to (mapping of int to StoredLane)
        Stored blocks by the labels of scheme and problem, then by block number.
    guards : mapping of (str, str) to (mapping of int to StoredLane)
        As `lanes`, with paths on the guard levels.
    damaged : int
        Number of pieces of evidence that cannot be read.
    """

    saved: SavedRun
    fingerprint: str
    lanes: Mapping[tuple[str, str], Lanes]
    guards: Mapping[tuple[str, str], Lanes]
    damaged: int = 0

    @property
    def folder(self) -> Path:
        """Folder of the run."""
        return self.saved.folder

    @property
    def settings(self) -> Settings:
        """Settings of the run."""
        return self.saved.settings

    @property
    def guarding(self) -> "StoredRun":
        """The run restricted to the guard levels."""
        return replace(self, saved=replace(self.saved, settings=self.settings.guards), lanes=self.guards)


def read_run(folder: Path) -> StoredRun:
    """Read the evidence of a run; stored code is never executed.

    Parameters
    ----------
    folder : Path
        Folder written by ``matrix`` or ``gate``.

    Raises
    ------
    UsageError
        If it is not such a folder or holds no evidence; the message gives the reason if the folder shows it.
    """
    saved = read_saved(folder)
    # The tables are not compared, but damaged ones show that the folder has been altered.
    read_verdicts(folder)
    read_table(folder / LEVELS)
    # Keyed by the number of levels.
    lanes: dict[str, dict[tuple[str, str], dict[int, StoredLane]]] = defaultdict(lambda: defaultdict(dict))
    every, few = str(saved.settings.levels), str(saved.settings.guards.levels)
    damaged = 0
    for lane in (lane for path in containers(folder / FOLDER) for _, lane in all_lanes(path)):
        damaged += lane is None
        if lane is not None and _is_of(lane, saved):
            # Evidence of earlier versions remains in the folder; the last one used counts.
            for levels in {every, few} if lane.block == SCREENING else {lane.ingredients["levels"]}:
                lanes[levels][lane.scheme, lane.problem][lane.block] = lane
    if not lanes and (damaged or not _is_decided_early(folder)):
        raise UsageError(why_absent(folder, damaged))
    return StoredRun(saved, str(run_of(folder).get(FINGERPRINT, "")), lanes[every], lanes[few], damaged)


def verdict_pairs(old: Path, new: Path) -> list[dict[str, str]]:
    """Return the verdicts of two runs on all quantities that both judged: names, before, after.

    A verdict on a whole cell, such as a broken contract, counts for each quantity that the other run has there.
    """
    tables = (read_verdicts(run) for run in (old, new))
    befores, afters = ({key_of(row): row["verdict"] for row in (*t.verdicts, *t.classes)} for t in tables)
    both = ((key, _verdict_in(befores, key), _verdict_in(afters, key)) for key in {**befores, **afters})
    return [{**key._asdict(), "before": before, "after": after} for key, before, after in both if before and after]


class ConstantChange(NamedTuple):
    """A leading weak error, known without sampling, that is another one in a later run.

    Attributes
    ----------
    key : Key
    before, after : Leading
    """

    key: Key
    before: Leading
    after: Leading


def constant_changes(old: Path, new: Path) -> list[ConstantChange]:
    """Return the leading weak errors of the runs in two folders that differ by more than what is known of them."""
    befores, afters = ({key_of(row): row for row in read_tables(run).details} for run in (old, new))
    pairs = [(key, befores[key], afters[key]) for key in befores if key in afters]
    return [ConstantChange(key, Leading.of(a), Leading.of(b)) for key, a, b in pairs if _differ(a, b)]


def _differ(a: TextRow, b: TextRow) -> bool:
    before, after = Leading.of(a), Leading.of(b)
    if not (str(before) and str(after)) or before.power != after.power:
        return bool(str(before) and str(after))
    known = sum(number(row, "error_constant_known") for row in (a, b))
    return abs(before.constant - after.constant) > known


def _verdict_in(verdicts: Mapping[Key, str], key: Key) -> str:
    return verdicts.get(key, verdicts.get(key._replace(quantity=""), ""))


def why_not_on_common_noise(old: StoredRun, new: StoredRun) -> str:
    """Return how noise or step sizes of two runs differ, or an empty string."""
    pairs = {name: (getattr(old.settings, name), getattr(new.settings, name)) for name in COMMON}
    pairs["stream of noise"] = (old.fingerprint, new.fingerprint)
    different = [f"{name} {a} in {old.folder} and {b} in {new.folder}" for name, (a, b) in pairs.items() if a != b]
    return f"errors are compared on common noise, with the same settings: {'; '.join(different)}" if different else ""


def _is_of(lane: StoredLane, saved: SavedRun) -> bool:
    # The folder also holds evidence on controls and of earlier runs.
    given = lane.ingredients
    named = given.get("scheme") in saved.schemes and given.get("problem") in saved.problems
    numbers = any(
        all(given.get(name) == str(getattr(settings, name)) for name in COMMON)
        for settings in (saved.settings, saved.settings.guards)
    )
    return named and numbers and given.get("index", "").removeprefix("-").isdecimal()


# Tier of a broken contract, for which no path is simulated.
BEFORE_ANY_PATH = "T0"


def _is_decided_early(folder: Path) -> bool:
    return any(row.get("decided_by") == BEFORE_ANY_PATH for row in read_verdicts(folder).verdicts)


def why_absent(folder: Path, damaged: int) -> str:
    """Return in one line why a run has no evidence, and the remedy if it is known.

    Parameters
    ----------
    folder : Path
        Folder of the run.
    damaged : int
        Number of pieces of evidence that cannot be read.
    """
    if damaged:
        return f"{damages(folder, damaged)}; run matrix or gate with --out {folder}"
    reasons = list(_reasons(folder))
    more = f" (and {counted(len(reasons) - 1, 'more cell')})" if len(reasons) > 1 else ""
    cause = f"{reasons[0]}{more}" if reasons else f"run matrix or gate with --out {folder}"
    return f"{folder} holds no evidence of the run in it; {cause}"


def damages(folder: Path, damaged: int) -> str:
    """Return the number of damaged pieces of evidence in a sentence."""
    one = damaged == 1
    return f"{damaged} {'piece' if one else 'pieces'} of evidence in {folder} {'is' if one else 'are'} damaged"


def _reasons(folder: Path) -> Iterator[str]:
    for row in read_verdicts(folder).verdicts:
        early = " before any path" if row.get("decided_by") == BEFORE_ANY_PATH else ""
        if row.get("reason"):
            yield f"{key_of(row)}: {row.get('verdict')}{early}: {row['reason']}"
