"""Entries of an experiment for a terminal: a small table under each heading, at most 80 columns wide."""

from collections.abc import Iterator, Sequence
from itertools import compress
from math import floor, isfinite, log10

from rich.table import Table
from rich.text import Text

from sdaeverify.commands import empty_table, visible

from .exhibit import AGREES, DISAGREES, FEW, TableEntry

WIDTH = 80
# Numbers below this value are written with a power of 10.
SMALL = 1e-3
# Fraction of effective paths below which a remark on few paths is made.
FEW_PATHS = 0.1
WORDS = {AGREES: "yes", DISAGREES: "NO", FEW: "void", "": ""}
COLUMNS = ("here", "eff.", "scheme", "=scheme", "exact", "paper", "=here", "=exact")
EXPLAINED = {
    "here": "Brackets hold the standard error in units of the last digit.",
    "eff.": "eff.: effective paths, (sum y)^2/sum y^2, where they are fewer than a tenth of the paths; below 30 a "
    "comparison is void.",
    "scheme": "scheme: the scheme's own mean, found without sampling.",
    "=scheme": "=scheme: whether ours is within four standard errors of it.",
    "=here": "=here, =exact: whether the print agrees with ours, and with the exact number, up to half a unit of its "
    "last digit and four standard errors.",
}


def entry_tables(entries: Sequence[TableEntry]) -> Iterator[Text | Table]:
    """Yield a heading and a table for each group of entries."""
    cells = [_cells(entry) for entry in entries]
    kept = [name for name in COLUMNS if any(each[name] for each in cells)]
    groups: dict[str, list[tuple[TableEntry, dict[str, str]]]] = {}
    for entry, texts in zip(entries, cells, strict=True):
        groups.setdefault(entry.group, []).append((entry, texts))
    for group, pairs in groups.items():
        yield from map(Text, _wrap_heading(visible(group)))
        yield _table(pairs, kept)
        yield Text("")


def explanations(entries: Sequence[TableEntry]) -> Iterator[str]:
    """Yield the explanations of the columns shown."""
    cells = [_cells(entry) for entry in entries]
    yield from (text for name, text in EXPLAINED.items() if any(each[name] for each in cells))


def with_error(value: float, std_error: float) -> str:
    """Return a number up to the second digit of its standard error, as 2.0062(12); empty if it is not finite."""
    if not isfinite(value):
        return ""
    if not 0.0 < std_error < 1.0:
        return f"{value:.5g}" + (f" +- {std_error:.2g}" if std_error > 0.0 else "")
    # Small numbers in scientific notation, 3.34(35)e-07.
    size = max(abs(value), std_error)
    exponent = floor(log10(size)) if size < SMALL else 0
    digits = 1 - floor(log10(std_error)) + exponent
    power = f"e{exponent:+03d}" if exponent else ""
    return f"{value * 10.0**-exponent:.{digits}f}({std_error * 10.0 ** (digits - exponent):.0f}){power}"


def _cells(entry: TableEntry) -> dict[str, str]:
    few = entry.effective < FEW_PATHS * entry.paths
    return {
        "here": with_error(entry.value, entry.std_error),
        "eff.": f"{entry.effective:.1f}" if few else "",
        "scheme": _exactly(entry.expected),
        "=scheme": WORDS[entry.value_and_expected],
        "exact": _exactly(entry.exact),
        "paper": entry.printed.digits if entry.printed else "",
        "=here": WORDS[entry.print_and_value],
        "=exact": WORDS[entry.print_and_exact],
    }


def _table(pairs: Sequence[tuple[TableEntry, dict[str, str]]], kept: Sequence[str]) -> Table:
    names = list(dict.fromkeys(name for entry, _ in pairs for name in entry.at))
    rows = [
        [*(_short(entry.at.get(name, "")) for name in names), *(cells[name] for name in kept)]
        for entry, cells in pairs
    ]
    shown = [any(row[i] for row in rows) for i in range(len(names) + len(kept))]
    table = empty_table(*compress((*map(visible, names), *kept), shown))
    for row in rows:
        table.add_row(*(Text(visible(text)) for text in compress(row, shown)))
    return table


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _exactly(value: float) -> str:
    return f"{value:.8g}" if isfinite(value) else ""


def _wrap_heading(heading: str) -> Iterator[str]:
    """Yield the lines of a heading, broken after commas and at spaces only."""
    line = ""
    for part in heading.replace(",", ",\0").replace(" ", " \0").split("\0"):
        if line and len(line) + len(part) > WIDTH:
            yield line
            line = "    "
        line += part
    yield line
