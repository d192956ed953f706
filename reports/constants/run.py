"""Predicted and measured error constants of weak cells: ``python reports/constants/run.py``.

For each verified weak cell of ``reports/reference`` the leading error C h^p is found without sampling where moments
or the transition operator know the error, and predicted from the modified equation of the scheme where the equation
is linear: the two have nothing in common but the step. Both are compared with paths, those of the reference run and,
on some problems, 65536 more, at the finest level at which they tell the error to ten per cent, or at the finest one.

Writes ``constants.csv``, a row for each cell, and ``summary.txt``: what agrees, and what is not known.
"""

import csv
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from functools import lru_cache
from math import isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from leading_moments import leading_moments

import sdaeverify
from sdaeverify import Array, Problem, Scheme, Settings
from sdaeverify.forms import Delayed
from sdaeverify.probe.linear.equation import linear_equation, why_not_linear_equation
from sdaeverify.probe.linear.moments import moment_errors, observable_errors, quadratic_form, why_not_moments
from sdaeverify.probe.operator.functional_orders import (
    Coefficient,
    functional_orders,
    leading_error,
    order_of,
)
from sdaeverify.probe.operator.transition import why_not_operator
from sdaeverify.probe.operator.transition_errors import chart_observables, weak_errors
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_problems, select_schemes
from sdaeverify_orders.order_report import classes_of
from sdaeverify_orders.trees.classes import EquationClass
from sdaeverify_orders.trees.modified.equation import ModifiedEquation, modified_equation

HERE, REFERENCE = Path(__file__).parent, Path(__file__).parents[1] / "reference"
# Trees of more motions are more than are looked at.
MOTIONS = 3
# Relative: constants agree, and paths resolve an error if two standard errors are no more.
AGREE = 0.1
# Problems on which steps are cheap, with further paths.
SAMPLED = "gbm,linear-test,ou,spiral,circle,noncommuting,three-motions,harmonic-langevin,angle-pendulum"
FURTHER: dict[str, Any] = {"paths": 65536, "levels": "8..64", "max_looks": 1, "seed": 20261128, "progress": "none"}
Pair = tuple[str, str]
Rows = Sequence[Mapping[str, str]]


class Level(NamedTuple):
    """The weak error that paths show at a step size: to the exact solution, or to half the step size."""

    h: float
    error: float
    std_error: float
    between: bool

    @property
    def is_resolved(self) -> bool:
        """Whether the paths tell the error to ten per cent."""
        return bool(2.0 * self.std_error <= AGREE * abs(self.error))


@dataclass(frozen=True)
class Row:
    """A verified weak cell: predicted and measured sizes of its error.

    Attributes
    ----------
    power, constant, known, found_by
        p and C of the leading error without sampling, how far C can be off, and what tells it.
    modified, modified_class
        C by the modified equation for a class.
    h, leading, exact, paths, std_error
        Step size, and there C h^p, the whole error without sampling, and that of paths; differences to half the step
        size where no solution is known.
    why_not
        Why C is not known.
    """

    scheme: str
    problem: str
    quantity: str
    power: float = nan
    constant: float = nan
    known: float = nan
    found_by: str = ""
    modified: float = nan
    modified_class: str = ""
    h: float = nan
    leading: float = nan
    exact: float = nan
    paths: float = nan
    std_error: float = nan
    why_not: str = ""

    @property
    def z(self) -> float:
        """How many standard errors paths are from the error without sampling."""
        return (self.paths - self.exact) / self.std_error if self.std_error > 0.0 else nan

    @property
    def is_resolved(self) -> bool:
        """Whether the paths tell the error to ten per cent."""
        return Level(self.h, self.paths, self.std_error, between=False).is_resolved


def agree(value: float, other: float) -> bool:
    """Return whether two sizes agree within ten per cent."""
    return abs(value - other) <= AGREE * abs(other)


def read(file: str) -> Rows:
    """Return the rows of a table of the reference run."""
    with (REFERENCE / file).open(newline="") as table:
        return [*csv.DictReader(table)]


@lru_cache(maxsize=1)
def registry() -> Any:
    """Return what is shipped."""
    return load_registry(environ={})


@lru_cache(maxsize=64)
def problem_of(label: str) -> Problem:
    """Return a problem by its label."""
    (spec,) = select_problems(registry(), label)
    return spec.build()


class Errors(NamedTuple):
    """Errors of a mean without sampling at some step sizes, with their order and what tells them."""

    h: Array
    errors: Array
    floors: Array
    order: float
    found_by: str

    def at(self, level: Level) -> float:
        """Return the error at the step size of a level, or the difference to half of it; NaN if it is not known."""
        own = self._at(level.h)
        return own - self._at(0.5 * level.h) if level.between else own

    def _at(self, h: float) -> float:
        place = int(np.argmin(np.abs(self.h - h)))
        return float(self.errors[place]) if np.isclose(self.h[place], h) else nan


def errors_of(scheme: Scheme, view: Problem) -> tuple[dict[str, Errors], str]:
    """Return the errors of means that are known without sampling, by observable, and why those of others are not."""
    if view.capability(Delayed):
        return {}, "it has a delay"
    steps = Settings().steps
    found, linear = {}, why_not_moments(scheme, view)
    if not linear:
        record = moment_errors(scheme, view, steps)
        linear = "" if record.known else "the step is not linear in the state"
        forms = {name: quadratic_form(view, name) for name in view.observables}
        told = {name: observable_errors(record, form) for name, form in forms.items() if form is not None}
        found = {name: Errors(*e[:3], order_of(*e).order, "moments") for name, e in told.items() if e is not None}
    chart = "no chart" if view.chart is None else why_not_operator(scheme, view)
    if not chart:
        operator = weak_errors(scheme, view, steps)
        chart = operator.why_not_evidence and "the scheme leaves the chart"
        orders, floors = functional_orders(operator), operator.floors
        for i, name in enumerate(chart_observables(view) if not chart else ()):
            own = Errors(operator.h, operator.errors[:, i], floors[:, i], orders[i].order, "operator")
            found.setdefault(name, own)
    return found, f"{linear or 'the mean is not quadratic'}; {chart or 'it is no function of the chart'}"


@lru_cache(maxsize=256)
def modified_of(scheme: Scheme, name: str, motions: int) -> ModifiedEquation:
    """Return the modified equation of a scheme for a class."""
    return modified_equation(scheme, classes_of(scheme)[name], motions)


def predictions(scheme: Scheme, view: Problem) -> tuple[str, float, dict[str, float]]:
    """Return the class whose modified equation says most, its order, and the constants of quadratic observables."""
    if view.noise_dim > MOTIONS or why_not_linear_equation(view):
        return "", nan, {}
    found = [
        modified_of(scheme, name, view.noise_dim)
        for name, kind in classes_of(scheme).items()
        if isinstance(kind, EquationClass) and not kind.overdamped and kind.motions in {None, view.noise_dim}
        if kind.traits <= view.traits
    ]
    best = max((each for each in found if each.terms), key=lambda each: each.order, default=None)
    ito = view.ito()
    if best is None or ito is None:
        return "", nan, {}
    moments = leading_moments(best, linear_equation(ito), ito.initial(1)[:, 0], view.horizon)
    forms = {name: quadratic_form(view, name) for name in view.observables}
    known = {name: form.of_moments(moments[:-1, -1], moments[:-1, :-1]) for name, form in forms.items() if form}
    return best.kind, best.order, {name: float(value) for name, value in known.items()}


def rows_of(
    pair: Pair, quantities: Sequence[str], levels: Mapping[tuple[str, ...], Sequence[Level]]
) -> Iterator[Row]:
    """Yield the rows of a scheme on a problem."""
    (scheme,) = select_schemes(registry(), pair[0])
    view = scheme.view_of(problem_of(pair[1]))
    assert view is not None
    with np.errstate(all="ignore"):
        known, why = errors_of(scheme, view)
        kind, order, constants = predictions(scheme, view) if known else ("", nan, {})
        for name in quantities:
            errors = known.get(name)
            found = None if errors is None else leading_error(*errors[:4])
            if errors is None or found is None:
                yield Row(*pair, name, why_not=why if errors is None else "no power of h stands out of its error")
                continue
            modified = constants.get(name, nan) if order == found.power else nan
            told = (*found, errors.found_by, modified, kind if isfinite(modified) else "")
            yield Row(*pair, name, *told, *_measured(found, errors, levels.get((*pair, name), ())))


def _measured(found: Coefficient, errors: Errors, levels: Sequence[Level]) -> tuple[float, ...]:
    """Return h, and there the leading error, the whole one, and that of paths with its standard error."""
    levels = [level for level in levels if isfinite(errors.at(level))]
    if not levels:
        return (nan,) * 5
    resolved = [level for level in levels if level.is_resolved] or levels
    best = min(resolved, key=lambda level: level.h)
    share = 1.0 - 0.5**found.power if best.between else 1.0
    return best.h, share * found.value * best.h**found.power, errors.at(best), best.error, best.std_error


def measured_levels(cells: Mapping[Pair, Sequence[str]]) -> dict[tuple[str, ...], list[Level]]:
    """Return what the paths of the reference run and further ones show, by cell."""
    schemes = ",".join(dict.fromkeys(scheme for scheme, _ in cells))
    further = sdaeverify.verify(schemes, SAMPLED, "weak", **FURTHER).levels.to_dict("records")
    found: dict[tuple[str, ...], list[Level]] = {}
    for row in (*read("levels.csv"), *further):
        if row["measure"] == "weak":
            level = Level(
                *(float(row[name]) for name in ("h", "estimate", "std_error")), str(row["coupled"]) == "False"
            )
            found.setdefault((row["scheme"], row["problem"], row["quantity"]), []).append(level)
    return found


def main() -> None:
    """Compare all verified weak cells, write the table and print what agrees."""
    cells: dict[Pair, list[str]] = {}
    for row in read("verdicts.csv"):
        if (row["measure"], row["verdict"]) == ("weak", "verified"):
            cells.setdefault((row["scheme"], row["problem"]), []).append(row["quantity"])
    levels = measured_levels(cells)
    rows = [row for pair, quantities in cells.items() for row in rows_of(pair, quantities, levels)]
    with (HERE / "constants.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([*(field.name for field in fields(Row)), "z"])
        table.writerows([_cell(each) for each in (*astuple(row), row.z)] for row in rows)
    lines = [*summary(rows)]
    (HERE / "summary.txt").write_text("\n".join([*lines, ""]), encoding="utf-8")
    print(*lines, sep="\n")


def _cell(value: object) -> object:
    return ("" if not isfinite(value) else f"{value:.6g}") if isinstance(value, float) else value


def summary(rows: Sequence[Row]) -> Iterator[str]:
    """Yield what agrees, and why the rest is not known."""
    known = [row for row in rows if isfinite(row.constant)]
    yield f"verified weak cells: {len(rows)}; constants known without sampling: {len(known)}"
    modified = [row for row in known if isfinite(row.modified)]
    worst = max((abs(row.modified / row.constant - 1.0) for row in modified), default=nan)
    near = sum(agree(row.modified, row.constant) for row in modified)
    yield f"predicted by modified equations: {len(modified)}"
    yield f"  within 10 per cent: {near}; largest relative difference {worst:.1e}"
    resolved = [row for row in known if row.is_resolved]
    whole, leading = (
        [row for row in resolved if agree(getattr(row, what), row.paths)] for what in ("exact", "leading")
    )
    yield f"resolved by paths to 10 per cent: {len(resolved)}"
    yield f"  whole error within 10 per cent of paths: {len(whole)}"
    higher = [row for row in resolved if not agree(row.leading, row.exact)]
    near = len(resolved) - len(higher)
    yield f"  leading error within 10 per cent of paths: {len(leading)}; of the whole error: {near}"
    for row in (row for row in resolved if row not in whole or (row not in leading and row not in higher)):
        sizes = f"leading {row.leading:.3g}, whole {row.exact:.3g}, paths {row.paths:.3g} +- {row.std_error:.1g}"
        yield f"  {row.scheme} on {row.problem}, {row.quantity}: {sizes}"
    z = [abs(row.z) for row in known if isfinite(row.z)]
    beyond = ", ".join(f"{sum(each > limit for each in z)} beyond {limit}" for limit in (2, 3, 4))
    yield f"standard errors between paths and the whole error, of {len(z)} cells: {beyond}"
    yield "not known:"
    for why, count in Counter(row.why_not for row in rows if row.why_not).most_common():
        yield f"  {count}: {why}"


if __name__ == "__main__":
    main()
