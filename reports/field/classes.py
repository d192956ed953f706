"""Asks the solvers of other libraries for the order conditions of classes of SDEs.

Writes classes.csv, a row for each solver, class and measure, and the table of README.md. One step on the universal
SDE of a class tells all elementary weights, so that a row is about every smooth SDE of the class.

pip install '.[diffrax,qutip,sdeint,tinydiffeq,torchsde]' && python reports/field/classes.py [SOLVERS]
"""

import os
import sys
import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from math import isnan
from multiprocessing import get_context
from pathlib import Path

import pandas as pd

from sdaeverify import SDE, Langevin
from sdaeverify.measuring import Verdict
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_schemes
from sdaeverify_orders.class_row import ClassRow
from sdaeverify_orders.order_report import classes_named
from sdaeverify_orders.trees.classes import CLASSES, EquationClass
from sdaeverify_orders.trees.report import rows_of

FOLDER = Path(__file__).parent
SOLVERS = "diffrax*,torchsde*,sdeint*,tinydiffeq*,qutip*"
# Orders up to 2 need trees up to this weight. Where noise of two motions is not additive or diagonal they are so many
# that they go half an order beyond what is documented.
MOTIONS, HIGH = 2, 5
KINDS = {kind.name: kind for kind in CLASSES}
FEW = ("ode", "scalar", "additive", "diagonal")
MANY = ("commutative", "vanishing-milstein-term", "general")
# What is asked of three motions, too, where a solver is given areas: their order counts then.
ORDERED = "general"
# Of solvers of Langevin equations, which have a bridge of their own; not in the table.
LANGEVIN = "langevin,langevin-gradient"
# QuTiP solves linear equations alone; an entry of the table is then about these.
LINEAR = tuple(
    EquationClass(f"{kind.name}, linear", kind.traits, kind.motions, linear=True)
    for kind in (KINDS[name] for name in ("ode", "scalar", "additive"))
)
BEGIN, END = "<!-- classes: written by classes.py -->", "<!-- end of classes -->"


def rows(label: str) -> list[dict[str, object]]:
    """Return the rows of a solver."""
    warnings.simplefilter("ignore")
    [scheme] = select_schemes(load_registry(), label)
    if Langevin in scheme.forms:
        return [row.cells for row in rows_of(scheme, classes_named(scheme, LANGEVIN), MOTIONS)]
    few, many = ([KINDS[name] for name in names] for names in (FEW, MANY))
    found = [*rows_of(scheme, few, MOTIONS, HIGH), *rows_of(scheme, many, MOTIONS)]
    if "A" in scheme.noise:
        found += rows_of(scheme, [KINDS[ORDERED]], 3)
    if not any(map(applies, found)):
        found = list(rows_of(scheme, LINEAR, MOTIONS, HIGH))
    return [row.cells for row in found if applies(row)]


def applies(row: ClassRow) -> bool:
    """Tell whether the solver takes equations of the class."""
    return row.verdict is not Verdict.NOT_APPLICABLE


def table(found: pd.DataFrame) -> Iterator[str]:
    """Yield the lines of the table of README.md."""
    names = [*FEW, *MANY]
    yield f"| solver | {' | '.join(names)} |"
    yield "|---" * (1 + len(names)) + "|"
    in_plane = found[found["motions"] <= MOTIONS].assign(column=found["class"].str.removesuffix(", linear"))
    in_plane = in_plane[in_plane["column"].isin(names)]
    for scheme, of_scheme in in_plane.groupby("scheme", sort=True):
        cells = (_cell(of_scheme[of_scheme["column"] == name].itertuples()) for name in names)
        yield f"| `{scheme}` | {' | '.join(cells)} |"


def _cell(of_class: Iterable[ClassRow]) -> str:
    """Return the strong and the weak order, each with the documented one behind it if that is another."""
    return " / ".join(map(_order, of_class)) or "-"


def _order(row: ClassRow) -> str:
    if isnan(row.order):
        return "not known"
    if isnan(row.claim):
        return f"*{row.order:g}*"
    return f"{row.order:g}" if row.order == row.claim else f"{row.order:g} ({row.claim:g})"


def write_table(lines: Iterable[str]) -> None:
    """Put the table in its place in README.md."""
    page = FOLDER / "README.md"
    before, rest = page.read_text().split(BEGIN)
    page.write_text("\n".join([before + BEGIN, "", *lines, "", END + rest.split(END)[1]]))


def main() -> None:
    """Ask all solvers that are installed, or those that are named, and write what is found in place of their rows."""
    # Nearly all of the time is that of compiling steps for the class at hand.
    os.environ |= {"OMP_NUM_THREADS": "1", "JAX_PLATFORMS": "cpu", "XLA_FLAGS": "--xla_backend_optimization_level=0"}
    asked = sys.argv[1] if sys.argv[1:] else SOLVERS
    labels = [each.label for each in select_schemes(load_registry(), asked) if {SDE, Langevin} & {*each.forms}]
    with ProcessPoolExecutor(os.cpu_count(), get_context("spawn")) as pool:
        found = pd.DataFrame([row for some in pool.map(rows, labels) for row in some])
    file = FOLDER / "classes.csv"
    if sys.argv[1:] and file.exists():
        known = pd.read_csv(file)
        found = pd.concat([known[~known["scheme"].isin(labels)], found])
    found.sort_values("scheme", kind="stable").to_csv(file, index=False, float_format="%.3g")
    write_table(table(pd.read_csv(FOLDER / "classes.csv")))
    print(found["verdict"].value_counts().to_string())


if __name__ == "__main__":
    sys.exit(main())
