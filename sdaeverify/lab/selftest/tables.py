"""The kill matrix as a table of text and for a terminal."""

from collections.abc import Iterator

import pandas as pd
from rich.table import Table
from rich.text import Text

from ...report.plain import empty_table, visible
from .kills import BugResult, KillMatrix

MARKS = {True: ("✓", "x"), False: ("·", ".")}


def kill_table(matrix: KillMatrix) -> pd.DataFrame:
    """Return a row for each planted bug, with 1 under each check that refutes it."""
    rows = []
    for bug in matrix.bugs:
        planted = bug.planted
        named = {"bug": planted.bug, "scheme": planted.scheme.label, "problem": planted.problem}
        marks = {str(check): int(check in bug.kills) for check in matrix.checks}
        rows.append({**named, **marks, "outcome": outcome(bug), "reason": bug.reason, "seconds": bug.seconds})
    return pd.DataFrame(rows)


def outcome(bug: BugResult) -> str:
    """Return what became of a bug in words."""
    if bug.planted.equivalent:
        return "refuted though equivalent" if bug.kills else "equivalent"
    return "refuted" if bug.kills else "survives"


def terminal_table(matrix: KillMatrix, *, plain: bool = False) -> Table:
    """Return the kill matrix with a mark for each check that refutes a bug.

    Parameters
    ----------
    matrix : KillMatrix
    plain : bool
        Whether only ASCII can be shown.
    """
    table = empty_table("bug", "scheme", "problem")
    for check in matrix.checks:
        table.add_column(f"{check.measure}\nT{check.tier}", no_wrap=True, justify="center")
    for bug in matrix.bugs:
        planted, style = bug.planted, "" if bug.as_expected else "bold red"
        names = (planted.bug, planted.scheme.label, planted.problem)
        marks = (Text(MARKS[check in bug.kills][plain]) for check in matrix.checks)
        table.add_row(*(Text(visible(name), style=style) for name in names), *marks)
    return table


def in_words(matrix: KillMatrix) -> Iterator[Text]:
    """Give what did not come out as it must, the equivalent changes, and the counts, a line each."""
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
    """Return in one sentence how many bugs were refuted, and how many correct claims."""
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
