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


def test_one_plan_is_itself():
    """A union of one plan has its cells."""
    plan = plan_of(gbm, [EULER, MILSTEIN], [STRONG, WEAK])

    assert sorted(named(union([plan]))) == sorted(named(plan))
    assert union([]) == Plan(())


def test_disjoint_plans():
    """Cells of both are there, problems in the order of their labels."""
    whole = union([plan_of(ou, [EULER], [STRONG]), plan_of(gbm, [MILSTEIN], [WEAK])])

    assert named(whole) == [("gbm", "milstein", "weak"), ("ou", "euler-maruyama", "strong")]


def test_an_order_that_is_asked_for():
    """Problems and schemes come as they are named, and what is not named behind them."""
    plans = [plan_of(gbm, [EULER, MILSTEIN, THETA], [STRONG]), plan_of(ou, [MILSTEIN], [WEAK])]

    whole = union(plans, [MILSTEIN.label, THETA.label], ["ou"])

    assert [cell.spec.label for cell in whole.cells] == ["ou", "gbm", "gbm", "gbm"]
    assert [cell.scheme.label for cell in whole.cells[1:]] == [MILSTEIN.label, THETA.label, EULER.label]


def test_no_cell_is_made_up():
    """What no run had is in no cell: the union is no product."""
    whole = union([plan_of(gbm, [EULER], [STRONG]), plan_of(gbm, [MILSTEIN], [WEAK])])

    assert named(whole) == [("gbm", "euler-maruyama", "strong"), ("gbm", "milstein", "weak")]
    assert len(whole.problems) == 1


def test_cells_of_both_are_there_once():
    """A cell that two runs have is one."""
    whole = union([plan_of(gbm, [EULER, MILSTEIN], [STRONG]), plan_of(gbm, [MILSTEIN, THETA], [STRONG])])

    assert named(whole) == [
        ("gbm", "euler-maruyama", "strong"),
        ("gbm", "milstein", "strong"),
        ("gbm", "stochastic-theta[theta=0.75]", "strong"),
    ]


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
