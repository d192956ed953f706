"""Verdicts of a run on claims about classes of equations, by order conditions or on random members.

A worker computes the conditions, or the members, of a class once. A scheme that hangs or kills its worker loses only
its own rows.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ..contracts.finding import UNMEASURED, Verdict
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..errors import FAULTS, one_line
from ..simulate.ensemble import Entry, Marker
from ..trees import TreeClass
from ..trees.class_row import ClassRow
from ..trees.classes import EquationClass, tree_classes_of
from ..trees.report import MEASURES, measures_of, rows_of
from ..workers.batches import Batch
from ..workers.calls import Lost
from ..workers.executors import Workers
from ..workers.marks import StopError
from .judging import CellResult
from .members.classes import MemberClass, member_classes
from .members.rows import member_rows

HERE = Workers(None, 1)
MEASURED = frozenset(Verdict) - UNMEASURED - {Verdict.NOT_APPLICABLE}
LATE = "no answer about a class within {:g} s (--timeout)"
SEED = Settings().seed
Kind = EquationClass | TreeClass | MemberClass
Rows = tuple[ClassRow, ...]


@dataclass(frozen=True)
class ClassTask:
    """A class of equations with the schemes whose claims about it are judged; it can be pickled.

    Attributes
    ----------
    kind : EquationClass, TreeClass or MemberClass
    entries : tuple of Entry
    seed : int
        Of the run.
    """

    kind: Kind
    entries: tuple[Entry, ...]
    seed: int = SEED

    @property
    def label(self) -> str:
        """Description of the task for error messages."""
        return f"of the class {self.kind.name}"

    def only(self, entries: Sequence[Entry]) -> "ClassTask":
        """Return the task with some of its entries."""
        return replace(self, entries=tuple(entries))


def class_rows(results: Sequence[CellResult], workers: Workers = HERE, seed: int = SEED) -> Rows:
    """Return the verdicts on the schemes' claims about classes, scheme by scheme.

    Schemes without any measured cell, because a step hangs or raises, are skipped.

    Parameters
    ----------
    results : sequence of CellResult
    workers : Workers
        Workers that evaluate the conditions; this process if omitted.
    seed : int
        Of the run; it determines the random members.
    """
    entries = _entries(results)
    kinds: dict[Kind, list[Entry]] = {}
    for entry in entries:
        for kind in _kinds_of(entry, seed):
            kinds.setdefault(kind, []).append(entry)
    sent = [(kind, Batch(workers, ClassTask(kind, tuple(own), seed), ask, LATE)) for kind, own in kinds.items()]
    found: dict[Scheme, list[ClassRow]] = {entry.scheme: [] for entry in entries}
    for kind, batch in sent:
        for entry, answer in batch.answers():
            found[entry.scheme] += _failed(entry, kind, answer.why) if isinstance(answer, Lost) else answer
    asked = {(entry.scheme, measure.name) for entry in entries for measure in entry.measures}
    return tuple(row for scheme, rows in found.items() for row in rows if (scheme, row.measure) in asked)


def _entries(results: Sequence[CellResult]) -> list[Entry]:
    """Return the schemes to examine, each with the measures of its cells."""
    failed = {each.cell.scheme for each in results if any(found.verdict in UNMEASURED for found in each.findings)}
    measured = {each.cell.scheme for each in results if any(found.verdict in MEASURED for found in each.findings)}
    asked: dict[Scheme, dict[str, Measure]] = {}
    for cell in (each.cell for each in results):
        if cell.scheme in measured or cell.scheme not in failed:
            asked.setdefault(cell.scheme, {})[cell.measure.name] = cell.measure
    return [Entry(scheme, tuple(measures.values())) for scheme, measures in asked.items()]


def _kinds_of(entry: Entry, seed: int) -> Iterator[Kind]:
    if any(measure.name in MEASURES for measure in entry.measures):
        yield from tree_classes_of(entry.scheme)
    for kind, claims in member_classes(entry.scheme, seed).items():
        if {claim.measure for claim in claims} & {measure.name for measure in entry.measures}:
            yield kind


def ask(task: ClassTask, marker: Marker) -> list[Rows]:
    """Return the rows of each scheme on a class.

    Parameters
    ----------
    task : ClassTask
    marker : Marker
        Records whose code is running.
    """
    return [_ask(entry, task, marker, index) for index, entry in enumerate(task.entries)]


def _ask(entry: Entry, task: ClassTask, marker: Marker, index: int) -> Rows:
    try:
        with marker.of(index):
            return tuple(rows_on(entry, task.kind, task.seed))
    except (StopError, *FAULTS) as error:
        return _failed(entry, task.kind, one_line(error))


def rows_on(entry: Entry, kind: Kind, seed: int = SEED) -> Iterator[ClassRow]:
    """Yield the verdicts on the claims of a scheme about a class.

    Parameters
    ----------
    entry : Entry
        The scheme, and the measures that judge random members.
    kind : EquationClass, TreeClass or MemberClass
    seed : int
        Of the run.
    """
    if isinstance(kind, MemberClass):
        yield from member_rows(entry.scheme, kind, entry.measures, seed)
    else:
        yield from rows_of(entry.scheme, [kind], None)


def _failed(entry: Entry, kind: Kind, why: str) -> Rows:
    own = tuple(measure.name for measure in entry.measures)
    measures = own if isinstance(kind, MemberClass) else measures_of(kind)
    motions = 0 if isinstance(kind, MemberClass) else kind.motions or 0
    return tuple(
        ClassRow(entry.scheme.label, kind.name, motions, measure, Verdict.ERROR, premise=why) for measure in measures
    )
