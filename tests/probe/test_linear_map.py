"""Linear maps of steps: known matrices are found, and steps that are not linear are noticed."""

import numpy as np
import pytest

from probe import linear_cells as c
from sdaeverify.probe.linear.affine import AFFINE, at_corners, defect, trial_states
from sdaeverify.probe.linear.linear_map import MemoryStep, linear_map
from sdaeverify.probe.step.nodes import step_nodes
from sdaeverify.probe.step.one_step import OneStep

EPS = np.finfo(float).eps
A = np.array([[-1.0, 0.5], [0.25, -2.0]])
C = np.array([[0.3, -0.1], [0.2, 0.4]])


def test_the_map_of_eulers_step_is_its_formula_at_every_node() -> None:
    """[[R, r], [0, 1]] has R = Id + h A + C dW and r = c dW."""
    problem, h, shift = c.linear(A, [(C, [0.5, 0.0])]), 0.1, np.array([0.5, 0.0])
    nodes = step_nodes(1, 3)
    found = linear_map(MemoryStep(OneStep(c.Formula(c.euler), problem), h), nodes)
    dW = np.sqrt(h) * nodes.dW[0]

    expected = (np.eye(2) + h * A)[..., None] + C[..., None] * dW
    assert found.factors[:2, :2] == pytest.approx(expected, abs=8 * EPS)
    assert found.factors[:2, 2] == pytest.approx(shift[:, None] * dW, abs=8 * EPS)
    assert (found.factors[2] == np.array([0.0, 0.0, 1.0])[:, None]).all()
    assert found.defect < 1e-14
    assert not found.failed


def test_memory_in_a_named_tuple_is_taken_apart_and_put_together() -> None:
    """The two-step scheme acts on (x, f_(n-1), walk) as its formulas say."""
    step = MemoryStep(OneStep(c.AdamsBashforth(), c.linear(-2.0, [0.5])), 0.1)
    nodes = step_nodes(1, 2)
    found = linear_map(step, nodes)

    dW = np.sqrt(0.1) * nodes.dW[0, 1]
    expected = [[1.0 - 0.3 + 0.5 * dW, -0.05, 0.0, 0.0], [-2.0, 0.0, 0.0, 0.0], [0.0, 0.0, 2.0, dW], [0, 0, 0, 1]]
    assert found.factors[..., 1] == pytest.approx(np.array(expected), abs=8 * EPS)
    assert (step.reading() == [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]).all()


def pulled(problem, x, h, noise):
    return c.euler(problem, x, h, noise) - 1e-9 * x * np.abs(x)


@pytest.mark.parametrize("rule", [c.tamed, pulled, lambda p, x, h, noise: np.where(x > 50.0, 0.0, x)])
def test_steps_that_are_not_linear_show_it(rule: c.Rule) -> None:
    """Taming, a quadratic term of relative size 1e-9 and a cut far out are defects, a thousand times rounding."""
    found = linear_map(MemoryStep(OneStep(c.Formula(rule), c.linear(-1.0, [0.5])), 0.1), step_nodes(1, 3))
    assert found.defect > AFFINE


def test_values_that_are_no_numbers_are_no_affine_function() -> None:
    """A NaN at a trial state is an infinite defect, and so is it at a corner."""
    x = trial_states(2)
    values = (3.0 * x[0] - x[1] + 2.0)[None, :, None]
    assert defect(values, at_corners(values[:, :3])) < 1e-14
    for place in (1, 5):
        broken = values.copy()
        broken[0, place] = np.nan
        assert defect(broken, at_corners(broken[:, :3])) == np.inf
