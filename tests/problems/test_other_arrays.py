"""Equations are formulas that the arrays of other libraries run, too: their solvers are judged on them."""

import pytest

from facade import load_registry, select_problems
from sdaeverify import SDE
from sdaeverify_bridges.kit import why_not_bridged

# Projections onto a sphere and matrices of the time are made by NumPy's own functions.
NUMPY_ALONE = {"sphere", "turning-frame"}
EQUATIONS = [spec.label for spec in select_problems(load_registry([])) if type(spec.build()) is SDE]


def test_there_are_equations_without_constraint():
    """The names of the exceptions are those of shipped problems."""
    assert NUMPY_ALONE.issubset(EQUATIONS)


@pytest.mark.parametrize("name", sorted(set(EQUATIONS) - NUMPY_ALONE))
def test_an_equation_runs_on_other_arrays(name):
    """No assignment to rows, and no function of NumPy that the library lacks."""
    (spec,) = select_problems(load_registry([]), name)
    assert why_not_bridged(spec.build()) == ""
