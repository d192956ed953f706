"""The experiments on delay equations: they run, and come out as measured before."""

from dataclasses import replace
from math import isnan

import numpy as np
import pytest

from experiments.running import lines_of, planned_run, with_rows
from facade import orders

pytestmark = pytest.mark.long

TABLE, FIGURES = "qu-2010-table-1", "qu-2010-figures-1-6"
# Mean squares of x with a reference at 1/8192 or finer, by 1/h, from an independent program.
MEASURED = {8: 2.962e-4, 16: 1.476e-4, 32: 7.22e-5, 64: 3.581e-5, 128: 1.751e-5}


def changed(registry, name, change, paths):
    """Run an experiment whose rows are changed, or left out where the change is None, and return its lines."""
    run = planned_run(registry, name, with_rows(registry, name, change, block=paths), paths)
    list(run.run())
    return lines_of(run)


def short_table(row):
    """Return the row with the same step size, up to a 32nd of the time."""
    reference = row.reference._replace(steps=row.reference.steps // 32)
    return replace(row, problem="delay-test[horizon=0.125]", steps=row.steps // 32, reference=reference)


def short_figure(row):
    """Return the row with the same step size, up to an eighth of the time."""
    return replace(row, problem=row.problem.replace("=10.0", "=1.25"), steps=row.steps // 8, at=row.at // 8)


def test_table_runs(registry):
    """All rows run with the step sizes of the table; x and y have an order each."""
    found = changed(registry, TABLE, short_table, 40)

    assert [line.h for line in found] == [1 / n for n in (8, 16, 32, 64, 128) * 2 + (4096, 4096)]
    assert all(line.sample.paths == 40 and not line.sample.error and not line.sample.lost for line in found)
    assert [(order.row.observable, order.step_sizes) for order in orders(found)] == [("x", 5), ("y", 5)]
    assert [line.row.printed.digits for line in found if line.row.printed] == [
        "2.9806e-04", "1.5971e-04", "7.2109e-05", "4.045e-05", "2.3559e-05",
    ]  # fmt: skip


def test_figures_run(registry):
    """All rows run with h = 1/32, and the scheme's means are known exactly where the equation is linear."""
    found = changed(registry, FIGURES, short_figure, 20)

    assert {line.h for line in found} == {1 / 32}
    assert all(line.sample.paths == 20 and not line.sample.error and not line.sample.lost for line in found)
    linear = [any(word in line.row.problem for word in ("l=0.0", "set=I,", "set=II,")) for line in found]
    assert [not isnan(line.scheme_mean.value) for line in found] == linear
    assert sum(linear) == 11 * 20
    assert len(found) == 15 * 20
    # Here, where no mean rests on rare paths, averages and exact means agree within four standard errors.
    assert {line.entry.value_and_expected for line in found if line.time <= 0.25} <= {"agrees", "void", ""}


@pytest.mark.slow
def test_table(registry):
    """Mean squares are those measured before, the print is wrong in its last entry, and x has order 1/2."""
    found = changed(registry, TABLE, lambda row: row if row.observable == "x" else None, 4000)

    *table, own = found
    for line, (finer, expected) in zip(table, MEASURED.items(), strict=True):
        assert line.h == 1 / finer
        assert abs(line.sample.value - expected) < 4.0 * line.sample.std_error
    # A reference of the paper's step would take 1/8 from the last mean square, and have an error of its own to show.
    assert abs(table[-1].sample.value - MEASURED[128] / 2) > 4.0 * table[-1].sample.std_error
    assert table[-1].entry.print_and_value == "disagrees"
    assert {line.entry.print_and_value for line in table[:3]} == {"agrees"}
    (order,) = orders(found)
    assert abs(order.estimate.value - 0.51) < 4.0 * np.hypot(order.estimate.se, 0.01)
    # To first order in h, the mean square of a step of 1/8192.
    assert own.sample.value == pytest.approx(table[-1].sample.value / 64, rel=0.3)


@pytest.mark.slow
def test_averages_that_lie(registry):
    """A scheme whose mean square grows as 1.0179^n seems to decay on 1000 paths, of which few are effective."""
    found = changed(registry, FIGURES, lambda row: row if "c=1.6" in row.problem else None, 1000)

    first, last = (next(line for line in found if line.time == t) for t in (1.0, 10.0))
    assert last.scheme_mean.value / first.scheme_mean.value == pytest.approx(1.0179 ** (9 * 32), rel=0.02)
    assert last.scheme_mean.factor == pytest.approx(1.0179, abs=5e-5)
    assert last.sample.value < 0.1 * first.sample.value
    assert last.entry.value_and_expected == "disagrees"
    assert last.sample.effective < 20
