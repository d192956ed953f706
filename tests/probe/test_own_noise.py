"""A step that shapes its noise itself: rules for means are not exact for it, and one step says nothing."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import scipy

from facade import (
    judge_weak,
    law_departure,
    load_registry,
    local_weak,
    noise_departure,
    select_problems,
    weak_order,
)
from probe.own_noise import SHAPES, OwnNoise, noisy
from sdaeverify import SDE, verify
from sdaeverify.measuring import Verdict
from sdaeverify_hunt import hunt
from sdaeverify_orders import orders
from sdaeverify_schemes.balanced_euler import BalancedEuler

# Each shape of each kind of noise is tried by the fast tests with one number of motions, in turn.
IN_TURN = [(name, of, 1 + turn % 3) for turn, (name, of) in enumerate(product(SHAPES, ("dW", "H")))]
CELLS = [
    pytest.param(*cell, id="-".join(map(str, cell)), marks=() if cell in IN_TURN else pytest.mark.long)
    for cell in product(SHAPES, ("dW", "H"), (1, 2, 3))
]
# In parts of the right size: less than a third of the variance.
WRONG = 0.55


@pytest.mark.parametrize("name", SHAPES)
def test_the_shapes_have_the_moments_of_a_weak_order_1(name):
    """Mean, variance and third moment are 0, 1 and 0, by the midpoint rule in the probability."""
    x = SHAPES[name](scipy.special.ndtri((np.arange(240_000) + 0.5) / 240_000))

    assert [float(np.mean(x**k)) for k in (1, 2, 3)] == pytest.approx([0.0, 1.0, 0.0], abs=1e-3)


@pytest.mark.sweep
@pytest.mark.parametrize(("name", "of", "motions"), CELLS)
def test_one_step_does_not_refute_noise_that_it_cannot_integrate(name, of, motions):
    """A right scheme is not refuted by the error of a rule, its wrong twin not verified; reasons name a remedy."""
    right, problem = OwnNoise(name, of), noisy(motions)

    found = judge_weak(weak_order(local_weak(right, problem)), 1.0)
    assert found.verdict is not Verdict.REFUTED
    if found.verdict is Verdict.INCONCLUSIVE:
        assert "must declare a law" in str(found.reason)
        assert "discontinuous_in_noise" in str(found.reason)
    wrong = weak_order(local_weak(replace(right, size=WRONG), problem))
    assert judge_weak(wrong, 1.0).verdict is not Verdict.VERIFIED


@pytest.mark.parametrize(
    "name", ["pendulum", "forced-ou", "levy-area", pytest.param("fibre-linear", marks=pytest.mark.long)]
)
def test_the_order_of_a_step_with_the_modulus_of_dw_is_seen(name):
    """Rules differ by a part of an error that is there: the balanced scheme has weak order 1/2, and not 1."""
    problem = select_problems(load_registry(), name)[0].build().view(SDE)
    found = weak_order(local_weak(BalancedEuler(), problem))

    assert judge_weak(found, 1.0).verdict is Verdict.REFUTED
    assert judge_weak(found, 0.5).verdict is Verdict.VERIFIED


@pytest.mark.sweep
@pytest.mark.parametrize(("name", "of", "motions"), CELLS)
def test_the_law_of_short_steps_is_told_from_the_errors_of_a_rule(name, of, motions):
    """A right scheme follows the equation; its wrong twin does not, by a rule or along drawn noise."""
    right, problem = OwnNoise(name, of), noisy(motions)
    wrong = replace(right, size=WRONG)

    assert not law_departure(right, problem)
    assert not noise_departure(right, problem, paths=False)
    assert law_departure(wrong, problem) or noise_departure(wrong, problem, paths=False)


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("of", ["dW", pytest.param("H", marks=pytest.mark.long)])
@pytest.mark.parametrize(
    "name", [*SHAPES][:1] + [pytest.param(name, marks=pytest.mark.long) for name in [*SHAPES][1:]]
)
def test_order_conditions_do_not_refute_noise_that_they_cannot_integrate(name, of):
    """No class with noise refutes a right scheme or verifies its wrong twin, H among it; the premise says why."""
    right, wrong = (orders(OwnNoise(name, of, size), motions=3, weight=3).table for size in (1.0, WRONG))
    right, wrong = (table[(table.motions > 0) & (table.claim == 1.0)] for table in (right, wrong))

    assert "refuted" not in set(right.verdict)
    assert "verified" not in set(wrong.verdict)
    told = right[right.verdict == "inconclusive"]
    assert all("must declare a law" in premise for premise in told.premise)


@pytest.mark.long
@pytest.mark.parametrize("of", ["dW", "H"])
def test_a_run_does_not_refute_three_point_variables_made_of_quantiles(of):
    """Three-point variables of weak solvers are refuted on no problem, those of a wrong variance on each."""
    right = OwnNoise("three_point", of)
    table = verify([right, replace(right, size=WRONG)], ["ou", "double-well"], "weak", paths=1024).verdicts

    assert "refuted" not in set(table[table.scheme == right.label].verdict)
    wrong = table[table.scheme != right.label]
    assert set(wrong.problem) == set(wrong[wrong.verdict == "refuted"].problem) == {"ou", "double-well"}


@pytest.mark.slow
@pytest.mark.long
def test_a_hunt_finds_wrong_noise_and_no_fault_of_a_rule():
    """Drawn equations do not refute three-point variables made of quantiles; they find a wrong variance at once."""
    right = OwnNoise("three_point")
    given = {"measures": "weak", "forms": ["SDE"], "shrinking": 2.0}

    assert hunt(right, examples=8, **given).found == ()
    assert hunt(replace(right, size=WRONG), examples=8, **given).found
