"""Each guard of verdicts has a cell that is judged wrongly without it."""

import pytest

from ablation import without
from facade import GUARDS, Guard, rules
from guard_cells import CELLS

# Guards whose cells take five seconds and more.
LATE = {"doubt end", "of memory", "turns", "withhold in doubt"}


def test_each_guard_has_its_cell():
    """A guard without one is removed, and each cell is one of a guard."""
    assert {guard.planted for guard in GUARDS} == set(CELLS)
    assert {guard.name for guard in GUARDS} > LATE


def test_guards_are_told_apart():
    """No two entries doubt the same by one function, and each says why, and which verdict it bars."""
    functions = [guard.asks for guard in GUARDS]
    assert len(functions) == len(set(functions))
    assert all(guard.bars and guard.reason for guard in GUARDS)


def test_the_guards_of_a_run_are_those_of_its_rules():
    """None is applied that is not in the tuple, in the same order."""
    of_runs = [rule for rule in rules.RULES if isinstance(rule, Guard)]
    assert [guard for guard in GUARDS if guard in of_runs] == of_runs


@pytest.mark.long
@pytest.mark.parametrize(
    "guard",
    [pytest.param(guard, id=guard.name, marks=pytest.mark.slow if guard.name in LATE else ()) for guard in GUARDS],
)
def test_a_cell_is_judged_wrongly_without_its_guard(guard):
    """More of its claims have the wrong verdict than with all guards."""
    cell = CELLS[guard.planted]
    guarded = list(cell.verdicts().values())
    with without(guard):
        found = list(cell.verdicts().values())
    assert found.count(cell.wrong) > guarded.count(cell.wrong)
