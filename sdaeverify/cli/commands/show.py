"""``show``: look again at a finished run, without running anything."""

import json
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from math import isnan
from pathlib import Path

import click

from ...errors import UsageError
from ...report.folders import RUN, SavedTables, TextRow, key_of, read_verdicts
from ...report.plain import in_columns, visible, wrap_text
from ...report.reading import Reading, Row, read_row, record
from ...report.sentences import (
    ATTENTION,
    Pair,
    PlainLine,
    counts_of,
    ending,
    interval,
    mark,
    other_value,
    quantity_lines,
)
from ...report.tables.command import command_of
from ..console import output, print_lines
from ..exit_codes import ExitCode

FOLDER = Path("reports", "latest")
HEADINGS = ("", "quantity", "claim", "one step", "along paths", "by")
INDENT = "    "


@click.command(short_help="Look again at a finished run.")
@click.argument("what", nargs=-1, metavar="[DIR] [SCHEME] [PROBLEM]")
@click.option("-m", "--measures", multiple=True, metavar="PATTERN", help="Measures: names or globs.")
@click.option("--open", "left_open", is_flag=True, help="What is refuted, failed or undecided, all of it.")
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each quantity.")
@click.option("-q", "--quiet", is_flag=True, help="Say the counts alone.")
def show(what: tuple[str, ...], measures: tuple[str, ...], left_open: bool, as_json: bool, quiet: bool) -> ExitCode:
    """Show what a run came to: DIR, reports/latest if left out; SCHEME and PROBLEM are names or globs.

    With SCHEME, what was found of each quantity; with PROBLEM, too, why, and the command that does it again.
    """
    folder, scheme, problem = _places(what)
    tables = read_verdicts(folder)
    chosen, absent = ([r for r in all_ if _fits(r, scheme, problem, measures)] for all_ in tables[1:3])
    if not (chosen or absent):
        about = ", ".join([" on ".join(filter(None, (scheme, problem))), *measures])
        raise UsageError(f"nothing in {folder} is about {about}")
    pairs = [(row, read_row(row)) for row in chosen]
    shown = [pair for pair in pairs if pair[1].verdict in ATTENTION] if left_open else pairs
    console = output()
    width, plain = console.width, console.options.ascii_only
    sentence = counts_of(chosen, absent)
    if as_json:
        click.echo(json.dumps([_record(row, tables) for row, _ in shown], indent=2))
    elif quiet:
        print_lines(console, map(PlainLine, wrap_text(sentence, width)))
    elif problem or left_open:
        print_lines(console, _cells(shown, tables, width, plain=plain))
        print_lines(console, _absent(absent if problem else [], width))
    elif scheme:
        print_lines(console, [*map(PlainLine, wrap_text(sentence, width)), *_overview(shown, width, plain=plain)])
    else:
        print_lines(console, ending(sentence, pairs, list(_notes(folder)), width, plain=plain))
    return ExitCode.OK


def _places(what: Sequence[str]) -> tuple[Path, str, str]:
    """Return folder, scheme and problem; a folder is what holds a run, or is written as a path."""
    words = list(what)
    folder = FOLDER
    if words and (len(words) > 2 or (Path(words[0]) / RUN).is_file() or _is_path(words[0])):
        folder = Path(words.pop(0))
    if len(words) > 2:
        raise UsageError(f"show takes a folder, a scheme and a problem, got {len(what)} words")
    scheme, problem = [*words, "", ""][:2]
    return folder, scheme, problem


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
    yield f"sdaeverify show {folder} SCHEME [PROBLEM] tells more"


def _overview(pairs: Sequence[Pair], width: int, *, plain: bool) -> Iterator[PlainLine]:
    """Yield what was found of each quantity, a table for each cell."""
    cells: dict[tuple[str, str], list[Pair]] = {}
    for row, reading in pairs:
        cells.setdefault((str(row["scheme"]), str(row["problem"])), []).append((row, reading))
    for (scheme, problem), found in cells.items():
        yield PlainLine("")
        yield PlainLine(visible(f"{scheme} on {problem}"))
        lines = in_columns([HEADINGS, *(_row(row, reading, plain=plain) for row, reading in found)])
        if max(map(len, lines)) <= width:
            yield from _table_lines(lines, found)
        else:
            yield from (line for pair in found for line in quantity_lines(pair, width, plain=plain, brief=True))


def _table_lines(lines: Sequence[str], found: Sequence[Pair]) -> Iterator[PlainLine]:
    """Yield the lines of a table, each in the style of its verdict."""
    yield PlainLine(lines[0])
    for line, (_, reading) in zip(lines[1:], found, strict=True):
        yield PlainLine(line, reading.verdict)


def _row(row: Row, reading: Reading, *, plain: bool) -> tuple[str, ...]:
    names = f"{row['measure']} {row['quantity']}"
    local = "" if isnan(reading.local_order) else f"{reading.local_order:.2f}"
    other = interval(reading.path) if reading.path.known else other_value(reading)
    claim = reading.claim.removeprefix("order ")
    claim = f"{claim} -{reading.margin:g}" if not isnan(reading.margin) else claim
    return mark(reading.verdict, plain=plain), visible(names), visible(claim), local, other, reading.decided_by


def _record(row: Row, tables: SavedTables) -> dict[str, object]:
    return {**record(row), "reproduce": command_of(row, tables.run) or None}


def _cells(pairs: Sequence[Pair], tables: SavedTables, width: int, *, plain: bool) -> Iterator[PlainLine]:
    cells: dict[tuple[str, ...], list[Pair]] = {}
    for row, reading in pairs:
        cells.setdefault(tuple(str(row[name]) for name in ("scheme", "problem", "measure")), []).append(
            (row, reading)
        )
    for (scheme, problem, measure), found in cells.items():
        yield PlainLine(visible(f"{scheme} on {problem}, {measure}"))
        for pair in found:
            yield from quantity_lines(pair, width, plain=plain)
        command = command_of(found[0][0], tables.run)
        yield from (PlainLine(line) for line in wrap_text(visible(f"  again: {command}"), width, INDENT) if command)
        yield PlainLine("")


def _absent(rows: Sequence[TextRow], width: int) -> Iterator[PlainLine]:
    """Yield what does not apply, measures with the same reason together."""
    reasons: dict[tuple[str, str, str], list[str]] = {}
    for row in rows:
        reasons.setdefault((row["scheme"], row["problem"], row["reason"]), []).append(key_of(row)[2])
    for (scheme, problem, reason), measures in reasons.items():
        told = f"does not apply: {scheme} on {problem}, {', '.join(measures)}: {reason}"
        yield from map(PlainLine, wrap_text(visible(told), width, INDENT))
