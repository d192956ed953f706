"""The lock file of the shipped schemes."""

from pathlib import Path

import pytest

from facade import Policy, class_cells, gate_plan, load_registry, read_lock

LOCK = Path(__file__).parents[2] / "sdaeverify.lock"


@pytest.mark.parametrize("tier", ["smoke", pytest.param("ci", marks=pytest.mark.long)])
def test_every_claimed_cell_is_locked(tier):
    """The cells of the lock file are those that a gate runs: a claim that is added or dropped changes the file."""
    plan = gate_plan(load_registry(environ={}), Policy(distribution="sdaeverify", tier=tier))
    cells = {(cell.scheme.label, cell.spec.label, cell.measure.name) for cell in plan.cells}

    locked = {key[:3] for key in read_lock(LOCK)[tier]}
    # A claim whose premise fails for a class is none of a gate.
    about_classes = {(cell.scheme.label, cell.spec.label, cell.measure.name) for cell in class_cells(plan.cells)}
    assert locked - about_classes == cells
    assert len(locked & about_classes) > len(about_classes) / 2
