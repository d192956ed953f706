"""The shipped experiments: they run, and Table 1 comes out as measured before."""

import re
from dataclasses import replace

import pytest

from experiments.euler_errors import lines_of
from facade import EXPERIMENTS, Budget, ExperimentRun, experiment_plan

TABLE = "laurent-2022-table-1"
UNIFORM, EULER = "uniformly-accurate[xi=three-point]", "constrained-euler[xi=three-point]"
# Means of the scheme as printed with their standard errors, by m and h, from an independent program.
MEASURED = {
    (2, UNIFORM, 128): (2.00192, 4e-5),
    (2, UNIFORM, 256): (2.00663, 4e-5),
    (2, EULER, 128): (1.991706, 6e-6),
    (3, UNIFORM, 128): (2.99555, 8e-5),
    (3, UNIFORM, 256): (3.00799, 7e-5),
    (3, EULER, 128): (2.97499, 2e-5),
}


def changed(registry, name, change, paths, budget=Budget.SMOKE):
    """Plan an experiment whose rows are changed, or left out where the change is None."""
    entry = registry.entries[EXPERIMENTS][name]
    rows = tuple(row for row in map(change, entry.thing.rows) if row is not None)
    other = replace(entry, things=(replace(entry.thing, rows=rows),))
    changed = replace(registry, entries={**registry.entries, "sdaeverify_experiments": {name: other}})
    return ExperimentRun(experiment_plan(changed, name, paths=paths, budget=budget))


def shorter(row):
    """Return the row with the same step size, up to a 64th of the time."""
    horizon = re.search(r"horizon=(\d+)", row.problem)
    problem = row.problem.replace(horizon[0], f"horizon={int(horizon[1]) / 64}")
    return replace(row, problem=problem, steps=row.steps // 64)


def matrices(row):
    """Keep m = 2 and 3."""
    return row if "m=2" in row.problem or "m=3" in row.problem else None


def test_shipped_experiment_runs(registry):
    """All rows, costly ones too, run with the step sizes of the experiment, and their exact values are known."""
    run = changed(registry, TABLE, shorter, 3, budget=Budget.FULL)
    list(run.run())

    for line in lines_of(run):
        assert line.sample.error == ""
        assert line.sample.paths == 3
        assert line.exact == line.exact
        assert line.sample.lost == line.sample.without_root == 0


def test_step_sizes(registry):
    """The shortened experiments have the step sizes of the whole ones."""
    whole, short = (lines_of(changed(registry, TABLE, change, 3)) for change in (replace, shorter))
    assert [line.h for line in whole] == [line.h for line in short]


@pytest.mark.slow
def test_table_1(registry):
    """Means are those measured before; at m = 3 they are told from the exact ones, and from the printed UA mean."""
    run = changed(registry, TABLE, matrices, 4000)
    list(run.run())

    found = lines_of(run)

    for line in found:
        m = int(re.search(r"m=(\d)", line.row.problem)[1])
        mean, std_error = MEASURED[m, line.row.scheme, line.row.steps]
        assert abs(line.sample.value - mean) < 4.0 * (line.sample.std_error**2 + std_error**2) ** 0.5
    uniform, finer, euler = found[3:]
    for line in (uniform, finer, euler):
        assert line.row.problem.startswith("orthogonal-group[eps=0.005,m=3")
    assert uniform.sample.value - uniform.exact < -4.0 * uniform.sample.std_error
    assert euler.sample.value - euler.exact < -4.0 * euler.sample.std_error
    assert (uniform.entry.print_and_value, euler.entry.print_and_value) == ("disagrees", "agrees")
    assert uniform.entry.print_and_exact == euler.entry.print_and_exact == "disagrees"
