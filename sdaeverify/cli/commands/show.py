"""``show``: print a finished run again, without running anything."""

from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import click
from rich.table import Table
from rich.text import Text

from ...contracts.claimed import AT_H
from ...contracts.spelling import did_you_mean
from ...errors import UsageError
from ...report.cells import grouped, number
from ...report.class_words import class_lines, class_notes, equation_lines, hint
from ...report.folders import RUN, SavedTables, TextRow, key_of, read_tables, read_verdicts
from ...report.plain import visible
from ...report.sentences import ATTENTION, counts_of, ending, overview, quantity_lines, wrap_styled
from ...report.tables.choice import Leading
from ...report.tables.command import command_of, records_of
from ...report.verdict_row import VerdictRow
from .. import options
from ..console import output, print_json, print_texts
from ..exit_codes import ExitCode

FOLDER = Path("reports", "latest")
INDENT = "    "


@click.command(short_help="Show the results of a finished run.")
@click.argument("what", nargs=-1, metavar="[DIR] [SCHEME] [PROBLEM]")
@click.option("-m", "--measures", multiple=True, metavar="PATTERN", help="Measures: names or globs.")
@click.option("--open", "left_open", is_flag=True, help="List everything that is refuted, failed or inconclusive.")
@options.as_json
@options.quiet
def show(what: tuple[str, ...], measures: tuple[str, ...], left_open: bool, as_json: bool, quiet: bool) -> ExitCode:
    """Show the results of a run in DIR, reports/latest if left out; SCHEME and PROBLEM are names or globs.

    With SCHEME, shows the finding on each quantity; with PROBLEM, also its reason and the command that reproduces it.
    """
    folder, scheme, problem = _places(what)
    if scheme and folder == FOLDER and not (folder / RUN).is_file():
        raise UsageError(f"{scheme} is not a folder, and there is no run in {folder} in which it could be a scheme")
    tables = read_verdicts(folder)
    # Verdicts on classes are selected by problem name, for example `every-equation`.
    judged = [*tables.verdicts, *tables.classes] if as_json or problem else tables.verdicts
    chosen, absent = ([r for r in some if _fits(r, scheme, problem, measures)] for some in (judged, tables.absent))
    rows = [*map(VerdictRow.from_row, chosen)]
    of_classes = [] if problem else [row for row in tables.classes if _fits(row, scheme, "", measures)]
    if not (rows or absent or of_classes):
        about = ", ".join(filter(None, [" on ".join(filter(None, (scheme, problem))), *measures])) or "any scheme"
        raise UsageError(f"nothing in {folder} is about {about}{_meant(folder, tables, scheme, problem, measures)}")
    shown = [row for row in rows if row.verdict in ATTENTION] if left_open else rows
    console = output()
    width, plain = console.width, console.options.ascii_only
    # A run of `orders` has verdicts on classes only.
    sentence = counts_of(rows, absent) if rows or absent else "no quantity of a problem"
    if as_json:
        print_json(records_of(shown, tables.run))
    elif quiet:
        print_texts(console, wrap_styled(sentence, width))
    elif problem or left_open:
        print_texts(console, _cells(shown, read_tables(folder) if problem else tables, width, plain=plain))
        print_texts(console, _absent(absent if problem else [], width))
    elif scheme:
        _print_scheme(sentence, overview(shown, plain=plain) if rows else (), _classes(of_classes, width))
        print_texts(console, _absent([] if rows else absent, width))
    else:
        print_texts(console, _classes([] if rows else of_classes, width))
        notes = [*class_notes(tables.classes), *tables.run.get("unseen", ()), *_notes(folder)]
        print_texts(console, ending(sentence, rows, notes, width, plain=plain))
    return ExitCode.OK


def _print_scheme(sentence: str, found: Iterable[Text | Table], of_classes: Iterable[Text]) -> None:
    console = output()
    print_texts(console, wrap_styled(sentence, console.width))
    for each in found:
        console.print(each)
    print_texts(console, of_classes)


def _places(what: Sequence[str]) -> tuple[Path, str, str]:
    """Return folder, scheme and problem; a word is a folder if it holds a run or is written as a path."""
    words = list(what)
    folder = FOLDER
    if words and (len(words) > 2 or (Path(words[0]) / RUN).is_file() or _is_path(words[0])):
        folder = Path(words.pop(0))
    if len(words) > 2:
        raise UsageError(f"show takes a folder, a scheme and a problem, got {len(what)} words")
    scheme, problem = [*words, "", ""][:2]
    return folder, scheme, problem


def _meant(folder: Path, tables: SavedTables, scheme: str, problem: str, measures: Sequence[str]) -> str:
    """Return a suggestion for a name that the run does not have, or the command that lists its names."""
    rows, hint = [*tables.verdicts, *tables.absent], f"; sdaeverify show {folder} shows what there is"
    for kind, word in (("scheme", scheme), ("problem", problem), *(("measure", each) for each in measures)):
        names = {row[kind] for row in rows}
        if word and not any(_is_named(name, word) for name in names):
            return did_you_mean(word, names) or hint
    return hint


def _is_path(word: str) -> bool:
    try:
        return "/" in word or Path(word).is_dir()
    except OSError:
        return False


def _fits(row: TextRow, scheme: str, problem: str, measures: Sequence[str]) -> bool:
    patterns = [pattern for text in measures for pattern in text.split(",")]
    return (
        _is_named(row["scheme"], scheme)
        and _is_named(row["problem"], problem)
        and (not patterns or any(_is_named(row["measure"], pattern) for pattern in patterns))
    )


def _is_named(name: str, pattern: str) -> bool:
    return (
        not pattern or name == pattern or fnmatchcase(name.partition("[")[0] if "[" not in pattern else name, pattern)
    )


def _notes(folder: Path) -> Iterator[str]:
    if (folder / "report.html").is_file():
        yield f"the page is {folder / 'report.html'}"
    yield f"sdaeverify show {folder} SCHEME [PROBLEM] shows more"


def _cells(rows: Sequence[VerdictRow], tables: SavedTables, width: int, *, plain: bool) -> Iterator[Text]:
    """Yield the findings on cells; measures with the same text, as for a step that raises, share a paragraph."""
    cells = grouped(rows, lambda row: (row.scheme, row.problem, row.measure)).items()
    told = [(cell, found, [*_findings(found, tables, width, plain=plain)]) for cell, found in cells]
    # A measure of an examination has a command of its own.
    own = {*tables.run.get("examined", {})}
    alike = grouped(told, lambda one: (*one[0][:2], frozenset({one[0][2]} & own), tuple(map(str, one[2]))))
    for (scheme, problem, *_), same in alike.items():
        measures = [measure for (*_, measure), *_ in same]
        yield from wrap_styled(visible(f"{scheme} on {problem}, {', '.join(measures)}"), width, INDENT)
        yield from same[0][2]
        command = command_of({**same[0][1][0].cells, "measure": ",".join(measures)}, tables.run)
        yield from wrap_styled(visible(f"  again: {command}"), width, INDENT) if command else ()
        yield Text()


def _findings(rows: Sequence[VerdictRow], tables: SavedTables, width: int, *, plain: bool) -> Iterator[Text]:
    """Yield the findings on the quantities of a cell, and the verdicts on its claim for classes of equations."""
    for row in rows:
        yield from quantity_lines(row, width, plain=plain)
        yield from _traceback(row, tables.details) if row.verdict == "error" else ()
        yield from _leading_error(row, tables.details, width)
    # Order conditions say nothing of a bound at one step size.
    orders = (row for row in rows if AT_H not in row.quantity)
    hints = dict.fromkeys(hint(tables.classes, row.scheme, row.measure, row.verdict) for row in orders)
    yield from (line for each in hints if each for line in wrap_styled(f"    {each}", width, INDENT))


def _leading_error(row: VerdictRow, details: Sequence[TextRow], width: int) -> Iterator[Text]:
    """Yield the leading error of a quantity, where it is known without sampling."""
    for each in (each for each in details if key_of(each) == row.key):
        if found := str(Leading.of(each)):
            known = number(each, "error_constant_known")
            yield from wrap_styled(
                f"    leading error {found} without sampling, C known to {known:.1g}", width, INDENT
            )


def _traceback(row: VerdictRow, details: Sequence[TextRow]) -> Iterator[Text]:
    """Yield the traceback of an error; the details table stores its line breaks as escapes."""
    key = row.scheme, row.problem, row.measure, row.quantity
    for text in (each.get("traceback", "") for each in details if key_of(each) == key):
        yield from (Text(visible(f"{INDENT}{line}")) for line in text.split("\\n") if text)


def _classes(rows: Sequence[TextRow], width: int) -> Iterator[Text]:
    """Yield the verdicts on claims about classes, scheme by scheme."""
    for label, own in grouped(rows, lambda row: row["scheme"]).items():
        if lines := [*class_lines(own, width)]:
            yield from (Text(), Text(visible(f"{label}: classes of equations")), *lines)
            yield from (Text(visible(f"  {line}".rstrip())) for line in equation_lines(own))


def _absent(rows: Sequence[TextRow], width: int) -> Iterator[Text]:
    """Yield cells that do not apply, with the measures of the same reason on one line."""
    for (scheme, problem, reason), same in grouped(rows, lambda r: (r["scheme"], r["problem"], r["reason"])).items():
        told = f"does not apply: {scheme} on {problem}, {', '.join(row['measure'] for row in same)}: {reason}"
        yield from wrap_styled(visible(told), width, INDENT)
