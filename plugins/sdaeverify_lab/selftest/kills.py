"""The kill matrix: which check refutes which planted bug, refuted correct claims, and their tables."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import pandas as pd
from rich.table import Table
from rich.text import Text

from sdaeverify import Scheme
from sdaeverify.commands import empty_table, visible
from sdaeverify.measuring import Finding, Verdict
from sdaeverify.studying import Cell, CellResult, tier_name

from ..cases import Planted
from .trial import SelfTest

CONTRACT = "contract"
# Verdicts that count for a class; order conditions with a failing premise are inconclusive and do not count.
DECIDED = {Verdict.VERIFIED, Verdict.REFUTED, Verdict.ERROR}
MARKS = {True: ("✓", "x"), False: ("·", ".")}


class Refuter(NamedTuple):
    """A check that can refute a claim: a measure at one of its tiers, or the contract that precedes all measures."""

    tier: int
    measure: str

    def __str__(self) -> str:
        return f"{self.measure} {tier_name(self.tier)}"


@dataclass(frozen=True)
class BugResult:
    """Result for a planted bug.

    Attributes
    ----------
    planted : Planted
    kills : frozenset of Refuter
        Checks that refute one of its claims.
    reason : str
        Reason of the first refutation, or why there is none.
    seconds : float
    """

    planted: Planted
    kills: frozenset[Refuter]
    reason: str
    seconds: float = 0.0

    @property
    def as_expected(self) -> bool:
        """Whether a bug is refuted, or an equivalent change is not."""
        return bool(self.kills) != bool(self.planted.equivalent)


class JudgedCell(NamedTuple):
    """A finding on a registered scheme, and its cell."""

    cell: Cell
    finding: Finding


@dataclass(frozen=True)
class KillMatrix:
    """Result of a self-test.

    Attributes
    ----------
    bugs : tuple of BugResult
        Results of planted bugs, sorted by label.
    correct : tuple of JudgedCell
        Findings on claims of registered schemes.
    checks : tuple of Refuter
        Checks that judged a claim, the contract first.
    """

    bugs: tuple[BugResult, ...]
    correct: tuple[JudgedCell, ...]
    checks: tuple[Refuter, ...]

    @property
    def survivors(self) -> list[BugResult]:
        """Bugs that no check refutes."""
        return [bug for bug in self.bugs if not (bug.as_expected or bug.planted.equivalent)]

    @property
    def refuted(self) -> frozenset[Scheme]:
        """Planted schemes that are refuted on the problem of each of their bugs."""
        survive = {bug.planted.scheme for bug in self.bugs if not bug.kills}
        return frozenset(bug.planted.scheme for bug in self.bugs) - survive

    @property
    def equivalents(self) -> list[BugResult]:
        """Equivalent changes."""
        return [bug for bug in self.bugs if bug.planted.equivalent]

    @property
    def false_alarms(self) -> list[JudgedCell]:
        """Refuted claims of registered schemes."""
        return [judged for judged in self.correct if judged.finding.verdict is Verdict.REFUTED]

    @property
    def unmeasured(self) -> list[JudgedCell]:
        """Findings on registered schemes that could not be measured."""
        return [judged for judged in self.correct if judged.finding.verdict.unmeasured]

    @property
    def passed(self) -> bool:
        """Whether every bug is refuted, and no equivalent change or correct claim is."""
        return not self.false_alarms and all(bug.as_expected for bug in self.bugs)


def kill_matrix(trial: SelfTest, results: Sequence[CellResult]) -> KillMatrix:
    """Sort the results of a trial by planted bug and check.

    Parameters
    ----------
    trial : SelfTest
    results : sequence of CellResult
        Results of the plan of the trial.

    Returns
    -------
    KillMatrix
    """
    found: dict[Planted, list[CellResult]] = {bug: [] for bug in trial.placed}
    correct: list[JudgedCell] = []
    bugs_of: dict[Scheme, list[Planted]] = {}
    for bug in found:
        bugs_of.setdefault(bug.scheme, []).append(bug)
    for result in filter(_decides, results):
        planted = bugs_of.get(result.cell.scheme, [])
        for bug in planted:
            if result.cell.class_name is not None or trial.placed[bug].label == result.cell.spec.label:
                found[bug].append(result)
        if not planted:
            correct += (JudgedCell(result.cell, finding) for finding in result.findings if _counts(finding))
    bugs = [_result(bug, own) for bug, own in found.items()]
    bugs += (BugResult(bug, frozenset(), f"not run: {why}") for bug, why in trial.missing.items())
    bugs.sort(key=lambda bug: bug.planted.label)
    return KillMatrix(tuple(bugs), tuple(correct), tuple(sorted(_checks(filter(_decides, results)))))


def _decides(result: CellResult) -> bool:
    """Return whether a result is on a problem, or verifies, refutes or fails to measure a claim about a class."""
    return result.cell.class_name is None or any(finding.verdict in DECIDED for finding in result.findings)


def check_of(measure: str, finding: Finding) -> Refuter:
    """Return the check that gave a finding."""
    return Refuter(finding.tier, measure if finding.tier else CONTRACT)


def _counts(finding: Finding) -> bool:
    return finding.claim is not None or finding.verdict.unmeasured


def _checks(results: Iterable[CellResult]) -> set[Refuter]:
    return {
        check_of(result.cell.measure.name, finding)
        for result in results
        for finding in result.findings
        if finding.claim is not None and not finding.verdict.unmeasured
    }


def _result(bug: Planted, results: Sequence[CellResult]) -> BugResult:
    pairs = [(result.cell.measure.name, finding) for result in results for finding in result.findings]
    refuted = [(measure, finding) for measure, finding in pairs if finding.verdict is Verdict.REFUTED]
    kills = frozenset(check_of(measure, finding) for measure, finding in refuted)
    return BugResult(bug, kills, _reason(refuted or pairs), max((result.seconds for result in results), default=0.0))


def _reason(pairs: Sequence[tuple[str, Finding]]) -> str:
    """Return the finding of the lowest tier on a claim, classes last, or why there is no finding."""
    if not pairs:
        return "it has no claim that is measured"
    measure, finding = min(pairs, key=lambda pair: (pair[1].claim is None, pair[1].tier < 0, pair[1].tier))
    return f"{measure} {finding.quantity} {finding.verdict}: {finding.reason}"


def kill_table(matrix: KillMatrix) -> pd.DataFrame:
    """Return a row for each planted bug, with 1 for each check that refutes it."""
    rows = []
    for bug in matrix.bugs:
        planted = bug.planted
        named = {"bug": planted.bug, "scheme": planted.scheme.label, "problem": planted.problem}
        marks = {str(check): int(check in bug.kills) for check in matrix.checks}
        rows.append({**named, **marks, "outcome": outcome(bug), "reason": bug.reason, "seconds": bug.seconds})
    return pd.DataFrame(rows)


def outcome(bug: BugResult) -> str:
    """Return the outcome of a bug in words."""
    if bug.planted.equivalent:
        return "refuted though equivalent" if bug.kills else "equivalent"
    return "refuted" if bug.kills else "survives"


def terminal_table(matrix: KillMatrix, *, plain: bool = False) -> Table:
    """Return the kill matrix with a mark for each check that refutes a bug.

    Parameters
    ----------
    matrix : KillMatrix
    plain : bool
        Whether the output is restricted to ASCII.
    """
    table = empty_table("bug", "scheme", "problem")
    for check in matrix.checks:
        table.add_column(f"{check.measure}\n{tier_name(check.tier)}", no_wrap=True, justify="center")
    for bug in matrix.bugs:
        planted, style = bug.planted, "" if bug.as_expected else "bold red"
        names = (planted.bug, planted.scheme.label, planted.problem)
        marks = (Text(MARKS[check in bug.kills][plain]) for check in matrix.checks)
        table.add_row(*(Text(visible(name), style=style) for name in names), *marks)
    return table


def in_words(matrix: KillMatrix) -> Iterator[Text]:
    """Yield unexpected outcomes, equivalent changes and the counts, one line each."""
    for bug in matrix.survivors:
        yield _line("survives", "bold red", f"{bug.planted.bug} ({bug.planted.label}): {bug.reason}")
    for bug in matrix.equivalents:
        wrong, why = bool(bug.kills), bug.reason if bug.kills else bug.planted.equivalent
        yield _line(outcome(bug), "bold red" if wrong else "green", f"{bug.planted.bug}: {why}")
    for cell, finding in matrix.false_alarms:
        where = f"{cell.scheme.label} on {cell.spec.label}, {cell.measure.name} {finding.quantity}".rstrip()
        yield _line("false alarm", "bold red", f"{where}: {finding.reason}")
    for cell, finding in matrix.unmeasured:
        where = f"{cell.scheme.label} on {cell.spec.label}, {cell.measure.name}"
        yield _line(finding.verdict, "bold magenta", f"{where}: {finding.reason}")
    yield Text(counts(matrix), style="bold")


def counts(matrix: KillMatrix) -> str:
    """Return the numbers of refuted bugs and of refuted correct claims in a sentence."""
    equivalents = len(matrix.equivalents)
    bugs = len(matrix.bugs) - equivalents
    refuted, survived = bugs - len(matrix.survivors), equivalents - sum(bool(b.kills) for b in matrix.equivalents)
    alarms = len(matrix.false_alarms) or "none"
    return (
        f"{refuted} of {bugs} planted bugs are refuted, {survived} of {equivalents} equivalent changes are not; "
        f"of {len(matrix.correct)} findings on claims of registered schemes, {alarms} refuted"
    )


def _line(kind: str, style: str, words: str) -> Text:
    return Text.assemble((kind, style), f": {visible(' '.join(words.split()))}")
