"""A run as it is stored in its folder: evidence, settings, verdicts and leading errors."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from ...contracts.settings import Settings
from ...contracts.spelling import counted
from ...contracts.stages import SCREENING
from ...errors import UsageError
from ...store.container import all_lanes, containers
from ...store.lanes import StoredLane
from ...store.store import FOLDER
from ..cells import number
from ..folders import Key, SavedTables, key_of, read_tables, read_verdicts
from ..saved import SavedRun, read_run
from .choice import Leading

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
    tables : SavedTables
    damaged : int
        Number of pieces of evidence that cannot be read.
    """

    saved: SavedRun
    fingerprint: str
    lanes: Mapping[tuple[str, str], Lanes]
    guards: Mapping[tuple[str, str], Lanes]
    tables: SavedTables
    damaged: int = 0

    @classmethod
    def read(cls, folder: Path) -> "StoredRun":
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
        saved, tables = read_run(folder), read_tables(folder)
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
        fingerprint = str(tables.run.get(FINGERPRINT, ""))
        return cls(saved, fingerprint, lanes[every], lanes[few], tables, damaged)

    @property
    def folder(self) -> Path:
        """Folder of the run."""
        return self.saved.folder

    @property
    def settings(self) -> Settings:
        """Settings of the run."""
        return self.saved.settings

    @property
    def noise(self) -> dict[str, object]:
        """Everything that determines the noise and the step sizes, by name."""
        settings = {name: getattr(self.settings, name) for name in COMMON}
        return {**settings, "stream of noise": self.fingerprint}

    @property
    def damage(self) -> str:
        """Sentence on the number of damaged pieces of evidence; empty if there is none."""
        return damages(self.folder, self.damaged) if self.damaged else ""

    @property
    def verdicts(self) -> dict[Key, str]:
        """Verdicts by key, on problems and on classes of equations."""
        return {key_of(row): row["verdict"] for row in (*self.tables.verdicts, *self.tables.classes)}

    @property
    def leading_errors(self) -> dict[Key, tuple[Leading, float]]:
        """Leading errors that are known without sampling, by key, each with the bound of its error."""
        told = ((key_of(row), Leading.of(row), row) for row in self.tables.details)
        return {key: (leading, number(row, "error_constant_known")) for key, leading, row in told if str(leading)}

    @property
    def guarding(self) -> "StoredRun":
        """The run restricted to the guard levels."""
        return replace(self, saved=replace(self.saved, settings=self.settings.guards), lanes=self.guards)


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
