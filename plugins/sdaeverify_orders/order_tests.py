"""Tests of claims about classes of equations by order conditions and on random members, as a run asks for them."""

from collections.abc import Iterable, Iterator, Sequence

from sdaeverify import Scheme
from sdaeverify.measuring import Finding, Kind, Measure, Method, Reason, Verdict
from sdaeverify.studying import ClassTests, Completed, Entry
from sdaeverify.trees import TreeClass

from .class_row import ClassRow
from .members.classes import MemberClass, member_classes
from .members.rows import member_rows
from .trees.classes import EquationClass, tree_classes_of
from .trees.report import MEASURES, claimed_measures, measures_of, rows_of

AnyClass = EquationClass | TreeClass | MemberClass


class OrderTests(ClassTests[AnyClass]):
    """Order conditions for classes with trees, random members for the others."""

    def classes(self, entry: Entry, seed: int) -> Iterator[AnyClass]:
        """Yield the classes that a scheme and some measures are tested on."""
        names = {measure.name for measure in entry.measures}
        if names & {*MEASURES}:
            yield from tree_classes_of(entry.scheme)
        for kind, claims in member_classes(entry.scheme, seed).items():
            if {claim.measure for claim in claims} & names:
                yield kind

    def claimed(self, entry: Entry, seed: int) -> Iterator[AnyClass]:
        """Yield the classes that a claim about one of the measures is about."""
        names = {measure.name for measure in entry.measures}
        for kind in tree_classes_of(entry.scheme) if names & {*MEASURES} else ():
            if names & {*claimed_measures(entry.scheme, kind)}:
                yield kind
        answering = {measure.name for measure in entry.measures if answers(measure)}
        for members, claims in member_classes(entry.scheme, seed).items():
            if answering & {claim.measure for claim in claims}:
                yield members

    def findings(
        self, entry: Entry, kind: AnyClass, seed: int, *, modified: bool = False
    ) -> Iterator[tuple[str, Finding]]:
        """Yield the findings on a class."""
        if isinstance(kind, MemberClass):
            rows = member_rows(entry.scheme, kind, entry.measures, seed)
        else:
            rows = rows_of(entry.scheme, [kind], None, modified=modified)
        return map(finding_of, rows)

    def failed(self, entry: Entry, kind: AnyClass, why: str) -> Iterator[tuple[str, Finding]]:
        """Yield an error for each measure."""
        own = tuple(measure.name for measure in entry.measures)
        measures = own if isinstance(kind, MemberClass) else measures_of(kind)
        motions = 0 if isinstance(kind, MemberClass) else kind.motions or 0
        for measure in measures:
            row = ClassRow(entry.scheme.label, kind.name, motions, measure, Verdict.ERROR, premise=why)
            yield finding_of(row)


ORDER_TESTS = OrderTests()


def answers(measure: Measure) -> bool:
    """Return whether a measure can judge random members."""
    return type(measure).judge_member is not Measure.judge_member


def finding_of(row: ClassRow) -> tuple[str, Finding]:
    """Return a row as the name of its measure and a finding."""
    return row.measure, Finding(
        quantity="" if row.verdict is Verdict.ERROR else row.conditions,
        verdict=row.verdict,
        reason=Reason(row.why, Kind.NO_CLAIM if row.verdict is Verdict.OUT_OF_SCOPE else Kind.PLAIN),
        claim=row.promise,
        method=Method(row.conditions),
        details=row.details,
    )


def class_work(rows: Iterable[ClassRow], schemes: Iterable[Scheme], measures: Sequence[Measure]) -> Completed:
    """Return verdicts on claims about classes of equations as a completed examination, to be saved as a run.

    Parameters
    ----------
    rows : iterable of ClassRow
    schemes : iterable of Scheme
        Schemes of the rows.
    measures : sequence of Measure
        Measures of the rows.
    """
    entries = {scheme.label: Entry(scheme, tuple(measures)) for scheme in schemes}
    results = (each for row in rows for each in ORDER_TESTS.results(entries[row.scheme], row.kind, [finding_of(row)]))
    return Completed([*results], ("orders", "{scheme}"))
