"""Tests of claims about classes of equations, by plugins; a run has their results in addition to those of its cells.

A plugin names its tests by an entry point of the group ``sdaeverify.classes``. A worker tests each class once, for
all schemes together. A scheme that hangs or kills its worker loses only its own results.

An `Examination` begins with a table of a policy, before a gate. These tests begin with the results of a run: schemes
of which nothing could be measured are not tested, nor are claims about other measures.
"""

import os
from abc import ABC, abstractmethod
from collections.abc import Collection, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from ..contracts.finding import CONDITIONS, UNMEASURED, Verdict
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.specs import ProblemSpec
from ..errors import FAULTS, PluginError, one_line
from ..registry.discovery import enabled_entry_points, is_strict, load_entry, origin_of
from ..simulate.ensemble import Entry, Marker
from ..store.class_findings import ClassFindings, NamedFinding
from ..workers.batches import Batch
from ..workers.calls import Lost
from ..workers.executors import Workers
from ..workers.marks import StopError
from .every_equation import EVERY_EQUATION, ORDER_CONDITIONS, RANDOM_MEMBERS, every_equation
from .judging import CellResult, without_evidence
from .plan import Cell

GROUP = "sdaeverify.classes"
NO_TESTS = "this installation has no tests of claims about classes of equations"
HERE = Workers(None, 1)
MEASURED = frozenset(Verdict) - UNMEASURED - {Verdict.NOT_APPLICABLE}
LATE = "no answer about a class within {:g} s (--timeout)"
SEED = Settings().seed
# Class in the rows of a scheme whose classes a plugin cannot name.
UNNAMED = "unknown"


class NamedClass(Hashable, Protocol):
    """A class of equations; it can be pickled."""

    @property
    def name(self) -> str:
        """Name, for users."""


K = TypeVar("K", bound=NamedClass)


class ClassTests(ABC, Generic[K]):
    """Base of the tests of a plugin for claims about classes of equations; instances have no state.

    Attributes
    ----------
    order_conditions, random_members : str
        Kinds of tests: the quantity of their findings.
    """

    order_conditions: ClassVar[str] = ORDER_CONDITIONS
    random_members: ClassVar[str] = RANDOM_MEMBERS

    @abstractmethod
    def classes(self, entry: Entry, seed: int) -> Iterable[K]:
        """Yield the classes that a scheme and some measures are tested on, with a claim or without one.

        Parameters
        ----------
        entry : Entry
            The scheme and the measures.
        seed : int
            Of the run.
        """

    @abstractmethod
    def claimed(self, entry: Entry, seed: int) -> Iterable[K]:
        """Yield the classes that a claim about one of the measures is about; no step is made.

        Parameters
        ----------
        entry : Entry
            The scheme and the measures.
        seed : int
            Of the run.
        """

    @abstractmethod
    def findings(self, entry: Entry, kind: K, seed: int, *, modified: bool = False) -> Iterable[NamedFinding]:
        """Return the findings on a class, each with the name of its measure; those on other measures are left out.

        Parameters
        ----------
        entry : Entry
            The scheme and the measures.
        kind : NamedClass
            One that `classes` yields.
        seed : int
            Of the run.
        modified : bool
            Whether the details have the modified equation of the scheme, even if no claim is refuted.
        """

    @abstractmethod
    def failed(self, entry: Entry, kind: K, why: str) -> Iterable[NamedFinding]:
        """Return the findings on a class on which the scheme raises, hangs or kills its worker.

        Parameters
        ----------
        entry : Entry
            The scheme and the measures.
        kind : NamedClass
            One that `classes` yields.
        why : str
            What happened.
        """

    @staticmethod
    def results(entry: Entry, kind: str, findings: Iterable[NamedFinding]) -> Iterator[CellResult]:
        """Yield findings about a class as results of cells, in the tier of conditions.

        Parameters
        ----------
        entry : Entry
            The scheme and the measures; findings on other measures are left out.
        kind : str
            Name of the class.
        findings : iterable of (str, Finding)
            Each with the name of its measure.
        """
        measures = {measure.name: measure for measure in entry.measures}
        for name, finding in findings:
            if name in measures:
                method = None if finding.method is None else finding.method._replace(tier=CONDITIONS)
                found = replace(finding, tier=CONDITIONS, method=method)
                yield CellResult(_class_cell(entry.scheme, kind, measures[name]), (found,))


def class_tests() -> tuple[ClassTests[Any], ...]:
    """Return the tests of the installed plugins; `broken_tests` names those that are left out.

    Raises
    ------
    PluginError
        If one of them is broken, and the environment forbids broken plugins.
    """
    if is_strict(os.environ) and (broken := broken_tests()):
        raise PluginError("; ".join(broken))
    return tuple(tests for tests in _loaded() if isinstance(tests, ClassTests))


def broken_tests() -> tuple[str, ...]:
    """Return a line for each plugin whose tests of classes cannot be used."""
    broken = (tests for tests in _loaded() if isinstance(tests, str))
    return tuple(f"{why}; claims about its classes are not tested" for why in broken)


def _loaded() -> Iterator[ClassTests[Any] | str]:
    """Yield the tests of each plugin, or why they cannot be used."""
    for entry in enabled_entry_points(GROUP):
        try:
            tests = load_entry(entry, "the class test")
        except PluginError as error:
            yield str(error)
            continue
        wrong = f"the class test of {origin_of(entry)} is broken: expected ClassTests, got {type(tests).__name__}"
        yield tests if isinstance(tests, ClassTests) else wrong


@dataclass(frozen=True)
class ClassTask:
    """A class of equations with the schemes whose claims about it are tested; it can be pickled.

    Attributes
    ----------
    tests : ClassTests
    kind : NamedClass
    entries : tuple of Entry
    seed : int
        Of the run.
    modified : bool
        Whether the modified equations of all schemes are computed; otherwise only those of refuted ones.
    """

    tests: ClassTests[Any]
    kind: NamedClass
    entries: tuple[Entry, ...]
    seed: int = SEED
    modified: bool = False

    @property
    def label(self) -> str:
        """Description of the task for error messages."""
        return f"of the class {self.kind.name}"

    @property
    def asked(self) -> tuple[str, ...]:
        """What the findings depend on besides entries and code."""
        return type(self.kind).__qualname__, self.kind.name, str(self.seed), str(self.modified)

    def only(self, entries: Sequence[Entry]) -> "ClassTask":
        """Return the task with some of its entries."""
        return replace(self, entries=tuple(entries))


def class_results(
    results: Sequence[CellResult],
    workers: Workers = HERE,
    seed: int = SEED,
    *,
    tests: Sequence[ClassTests[Any]] | None = None,
    modified: bool = False,
    stored: ClassFindings | None = None,
) -> tuple[CellResult, ...]:
    """Return the results on the schemes' claims about classes, scheme by scheme.

    Schemes without any measured cell, because a step hangs or raises, are skipped.

    Parameters
    ----------
    results : sequence of CellResult
        Of the cells of a run.
    workers : Workers
        Workers that make the tests; this process if omitted.
    seed : int
        Of the run; it determines the random members.
    tests : sequence of ClassTests, optional
        Those of the installed plugins if omitted.
    modified : bool
        Whether the modified equations of all schemes are computed; otherwise only those of refuted ones.
    stored : ClassFindings, optional
        Findings of earlier runs, which are not computed again, and to which new ones are added.
    """
    entries, known = _entries(results), class_tests() if tests is None else tests
    asked: dict[tuple[ClassTests[Any], NamedClass], list[Entry]] = {}
    found: dict[Scheme, list[CellResult]] = {entry.scheme: [] for entry in entries}
    for entry, each in product(entries, known):
        try:
            for kind in each.classes(entry, seed):
                asked.setdefault((each, kind), []).append(entry)
        except FAULTS as error:
            found[entry.scheme] += _without_classes(each, entry, one_line(error))
    tasks = [ClassTask(each, kind, tuple(own), seed, modified) for (each, kind), own in asked.items()]
    recalled = [{} if stored is None else stored.recall(task) for task in tasks]
    sent = [_send(task, answers, workers) for task, answers in zip(tasks, recalled, strict=True)]
    for task, answers, batch in zip(tasks, recalled, sent, strict=True):
        computed = {} if batch is None else dict(batch.answers())
        if stored is not None and computed:
            stored.keep(task, {entry: own for entry, own in computed.items() if not isinstance(own, Lost)})
        for entry in task.entries:
            answer = answers[entry] if entry in answers else computed[entry]
            findings = task.tests.failed(entry, task.kind, answer.why) if isinstance(answer, Lost) else answer
            found[entry.scheme] += ClassTests.results(entry, task.kind.name, findings)
    return tuple(result for own in found.values() for result in own)


def _send(task: ClassTask, known: Collection[Entry], workers: Workers) -> Batch[tuple[NamedFinding, ...]] | None:
    """Submit a task without the entries whose findings are known; None if none is left."""
    left = [entry for entry in task.entries if entry not in known]
    return Batch(workers, task.only(left), run_class, LATE) if left else None


def _without_classes(tests: ClassTests[Any], entry: Entry, why: str) -> Iterator[CellResult]:
    """Yield errors of a scheme whose classes a plugin cannot name."""
    error = f"{type(tests).__qualname__}.classes of {type(tests).__module__}: {why}"
    for measure in entry.measures:
        yield without_evidence(_class_cell(entry.scheme, UNNAMED, measure), Verdict.ERROR, error)


def _entries(results: Sequence[CellResult]) -> list[Entry]:
    """Return the schemes to test, each with the measures of its cells."""
    failed = {each.cell.scheme for each in results if any(found.verdict in UNMEASURED for found in each.findings)}
    measured = {each.cell.scheme for each in results if any(found.verdict in MEASURED for found in each.findings)}
    asked: dict[Scheme, dict[str, Measure]] = {}
    for cell in (each.cell for each in results):
        if cell.scheme in measured or cell.scheme not in failed:
            asked.setdefault(cell.scheme, {})[cell.measure.name] = cell.measure
    return [Entry(scheme, tuple(measures.values())) for scheme, measures in asked.items()]


def run_class(task: ClassTask, marker: Marker) -> list[tuple[NamedFinding, ...]]:
    """Return the findings on each scheme on a class.

    Parameters
    ----------
    task : ClassTask
    marker : Marker
        Records whose code is running.
    """
    return [_run(entry, task, marker, index) for index, entry in enumerate(task.entries)]


def _run(entry: Entry, task: ClassTask, marker: Marker, index: int) -> tuple[NamedFinding, ...]:
    try:
        with marker.of(index):
            return tuple(task.tests.findings(entry, task.kind, task.seed, modified=task.modified))
    except (StopError, *FAULTS) as error:
        return tuple(task.tests.failed(entry, task.kind, one_line(error)))


def class_cells(cells: Iterable[Cell], seed: int = SEED) -> Iterator[Cell]:
    """Yield a cell for each class that a scheme's claims are about, for the schemes and measures of the given cells.

    No step is made.

    Parameters
    ----------
    cells : iterable of Cell
    seed : int
        Of the run.
    """
    tests = class_tests()
    for scheme, measure in dict.fromkeys((cell.scheme, cell.measure) for cell in cells):
        for kind in (kind for each in tests for kind in each.claimed(Entry(scheme, (measure,)), seed)):
            yield _class_cell(scheme, kind.name, measure)


def results_of_class(cell: Cell, seed: int = SEED) -> list[CellResult]:
    """Return the results on the claim of a cell about a class, computed in this process.

    Parameters
    ----------
    cell : Cell
        One that `class_cells` yields.
    seed : int
        Of the run.
    """
    entry = Entry(cell.scheme, (cell.measure,))
    known = ((each, kind) for each in class_tests() for kind in each.claimed(entry, seed))
    tests, kind = next(found for found in known if found[1].name == cell.class_name)
    return [*tests.results(entry, kind.name, tests.findings(entry, kind, seed))]


def _class_cell(scheme: Scheme, kind: str, measure: Measure) -> Cell:
    return Cell(scheme, ProblemSpec(EVERY_EQUATION, every_equation, (("of", kind),)), measure)
