"""Plans of several runs as one."""

import pytest

from facade import (
    Cell,
    ControlPlan,
    EulerMaruyama,
    Milstein,
    Plan,
    ProblemPlan,
    StochasticTheta,
    gbm,
    ou,
    problem_spec,
    union,
)
from sdaeverify import Control
from sdaeverify.measuring import Measure


class Strong(Measure):
    """A measure."""

    name = "strong"


class Weak(Measure):
    """Another measure."""

    name = "weak"


EULER, MILSTEIN, THETA = EulerMaruyama(), Milstein(), StochasticTheta(theta=0.75)
STRONG, WEAK = Strong(), Weak()


def plan_of(problem, schemes, measures, controls=()):
    """Return a plan of one problem."""
    spec = problem_spec(problem)
    cells = tuple(Cell(scheme, spec, measure) for scheme in schemes for measure in measures)
    return Plan((ProblemPlan(spec, spec.build(), cells, tuple(controls)),))


def named(plan):
    """Return the names of all cells."""
    return [(cell.spec.label, cell.scheme.label, cell.measure.name) for cell in plan.cells]


def strongly(problem, *schemes):
    """Return names of cells of the strong measure."""
    return [(problem, scheme.label, "strong") for scheme in schemes]


@pytest.mark.parametrize(
    ("plans", "cells"),
    [
        ([], []),
        ([plan_of(gbm, [MILSTEIN, EULER], [STRONG])], strongly("gbm", EULER, MILSTEIN)),
        (
            [plan_of(ou, [EULER], [STRONG]), plan_of(gbm, [MILSTEIN], [STRONG])],
            [*strongly("gbm", MILSTEIN), *strongly("ou", EULER)],
        ),
        (
            [plan_of(gbm, [EULER], [STRONG]), plan_of(gbm, [MILSTEIN], [WEAK])],
            [*strongly("gbm", EULER), ("gbm", "milstein", "weak")],
        ),
        (
            [plan_of(gbm, [EULER, MILSTEIN], [STRONG]), plan_of(gbm, [MILSTEIN, THETA], [STRONG])],
            strongly("gbm", EULER, MILSTEIN, THETA),
        ),
    ],
    ids=["none", "one", "disjoint", "no product", "each once"],
)
def test_the_cells_of_both_and_no_others(plans, cells):
    """Cells of all plans are there once, in the order of their labels, and none that no run had."""
    whole = union(plans)

    assert named(whole) == cells
    assert len(whole.problems) == len({problem for problem, *_ in cells})


def test_an_order_that_is_asked_for():
    """Problems and schemes come as they are named, and what is not named behind them."""
    plans = [plan_of(gbm, [EULER, MILSTEIN, THETA], [STRONG]), plan_of(ou, [MILSTEIN], [WEAK])]

    whole = union(plans, [MILSTEIN.label, THETA.label], ["ou"])

    assert [cell.spec.label for cell in whole.cells] == ["ou", "gbm", "gbm", "gbm"]
    assert [cell.scheme.label for cell in whole.cells[1:]] == [MILSTEIN.label, THETA.label, EULER.label]


@pytest.mark.parametrize("turned", [False, True])
def test_the_order_of_runs_does_not_matter(turned):
    """Cells and controls are those of the union whichever run comes first."""
    strong = ControlPlan(Control(measure="strong", order=1.0, positive="milstein", negative="euler-maruyama"))
    weak = ControlPlan(Control(measure="weak", order=1.0, positive="milstein", negative="euler-maruyama"))
    plans = [
        plan_of(gbm, [EULER], [STRONG], [strong]),
        plan_of(gbm, [MILSTEIN, EULER], [STRONG, WEAK], [strong, weak]),
    ]

    whole = union(reversed(plans) if turned else plans)

    assert len(named(whole)) == 4
    assert [plan.control.measure for plan in whole.problems[0].controls] == ["strong", "weak"]
