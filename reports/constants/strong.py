"""Known and measured root mean square errors at T of strong cells: ``python reports/constants/strong.py``.

On linear equations the error of a step that is linear in the state and a polynomial of its noise is known without
sampling at each step size, and its leading term C h^p is ``error_constant``. Both are compared with 16384 paths, for
all schemes whose strong order is verified on the problem, at the finest step size.

Writes ``strong.csv``, a row for each cell, and ``strong.txt``: what agrees.
"""

import csv
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

import sdaeverify
from sdaeverify.contracts.scheme import AT_T
from sdaeverify.measures.strong import rows_of_parts
from sdaeverify.probe.linear.strong_errors import strong_errors

HERE = Path(__file__).parent
PROBLEMS = "gbm,linear-test,ou,spiral,noncommuting,three-motions,harmonic-langevin,levy-area"
# Two looks would stop at fewer paths where a claim is decided.
RUN: dict[str, Any] = {"paths": 16384, "levels": "8..64", "max_looks": 1, "seed": 20261128, "progress": "none"}
# Relative: errors agree, and paths resolve an error if two standard errors of its mean are no more.
AGREE = 0.1


@dataclass(frozen=True)
class Row:
    """A verified strong quantity: root mean square errors at the finest step size.

    Attributes
    ----------
    power, constant, known
        p and C of the leading error, and how far C can be off.
    h, leading, exact, paths, relative
        Step size, and there C h^p, the whole error without sampling, that of paths, and the relative standard error
        of the mean error.
    """

    scheme: str
    problem: str
    quantity: str
    power: float
    constant: float
    known: float
    h: float
    leading: float
    exact: float
    paths: float
    relative: float

    @property
    def is_resolved(self) -> bool:
        """Whether the paths tell the error to ten per cent."""
        return 2.0 * self.relative <= AGREE


def agree(value: float, other: float) -> bool:
    """Return whether two sizes agree within ten per cent."""
    return abs(value - other) <= AGREE * abs(other)


def rows_of(result: Any) -> Iterator[Row]:
    """Yield the rows of verified quantities with a known constant."""
    details = result.details("strong")
    verified = {tuple(row) for row in result.verdicts.query("verdict == 'verified'")[[*KEY]].itertuples(index=False)}
    cells = {(each.cell.scheme.label, each.cell.spec.label): each.cell for each in result.results}
    for _, row in details[details["error_constant"].notna()].iterrows():
        key = tuple(row[name] for name in KEY)
        if key in verified:
            own = np.logical_and.reduce([result.levels[name] == row[name] for name in KEY])
            yield _row(row, result.levels[own].sort_values("h").iloc[0], cells[key[:2]])


KEY = ("scheme", "problem", "quantity")


def _row(details: Any, level: Any, cell: Any) -> Row:
    view = cell.scheme.view_of(cell.spec.build())
    found = strong_errors(cell.scheme, view, [round(view.horizon / level["h"])])
    component = details["quantity"].removesuffix(AT_T)
    exact = float(np.sqrt(found.squares[0, rows_of_parts(view)[component]].sum()))
    p, C = details["error_power"], details["error_constant"]
    paths, relative = level["estimate_L2"], level["std_error"] / level["estimate"] if level["estimate"] else nan
    key = tuple(details[name] for name in KEY)
    return Row(*key, p, C, details["error_constant_known"], level["h"], C * level["h"] ** p, exact, paths, relative)


def summary(rows: Sequence[Row]) -> Iterator[str]:
    """Yield what agrees."""
    yield f"verified strong quantities at T with a known constant: {len(rows)}"
    resolved = [row for row in rows if row.is_resolved]
    whole = [row for row in resolved if agree(row.exact, row.paths)]
    leading = [row for row in resolved if agree(row.leading, row.paths)]
    settled = [row for row in resolved if agree(row.leading, row.exact)]
    yield f"mean errors resolved by paths to 10 per cent: {len(resolved)}"
    yield f"  whole error within 10 per cent of paths: {len(whole)}"
    yield f"  leading error within 10 per cent of paths: {len(leading)}; of the whole error: {len(settled)}"
    for row in (row for row in resolved if row not in whole or (row in settled and row not in leading)):
        sizes = f"leading {row.leading:.3g}, whole {row.exact:.3g}, paths {row.paths:.3g}"
        yield f"  {row.scheme} on {row.problem}, {row.quantity}: {sizes}"


def main() -> None:
    """Compare all verified cells, write the table and print what agrees."""
    rows = [*rows_of(sdaeverify.verify("*", PROBLEMS, "strong", **RUN))]
    with (HERE / "strong.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([field.name for field in fields(Row)])
        table.writerows([f"{each:.6g}" if isinstance(each, float) else each for each in astuple(row)] for row in rows)
    lines = [*summary(rows)]
    (HERE / "strong.txt").write_text("\n".join([*lines, ""]), encoding="utf-8")
    print(*lines, sep="\n")


if __name__ == "__main__":
    main()
