"""What is shipped is right and what is planted is wrong: each beside its right twin, by the law alone."""

from dataclasses import replace

import numpy as np
import pytest

from sdaeverify import Claim
from sdaeverify.studying import Source
from sdaeverify_sealed import sealed
from sdaeverify_sealed.references import references
from sdaeverify_sealed.sample import Budget, plans
from sealed.solving import SMALL, rows, solver, spec, verdicts

pytestmark = pytest.mark.long

MORE, HALF = Budget(paths=2**18, looks=3), Budget(paths=2**17, looks=3)
# By problem: a right solver, and wrong ones with the row that tells each from it.
OU = ("planted-half-drift", "planted-loud", "planted-clipped")
LANGEVIN = [
    ("planted-warm", "own-baoab", ("invariant", "q^2"), MORE),
    ("planted-first-order", "own-euler", ("weak", "p^2"), HALF),
    ("planted-shared", "own-euler", ("standard errors", "weak means"), SMALL),
    ("planted-seedless", "own-euler", ("own seeds", ""), SMALL),
]


@pytest.mark.slow
def test_a_wrong_limit_is_refuted_and_the_right_one_verified():
    """The stationary mean of x^2 has order 1 for Euler's scheme, and none for three that tend to another law."""
    right, wrong = verdicts([solver("own-euler")], "ou", MORE), verdicts(list(map(solver, OU)), "ou", HALF)

    assert right["own-euler", "invariant", "x^2"] == "verified"
    assert "refuted" not in right.values()
    assert [name for name in OU if wrong[name, "invariant", "x^2"] != "refuted"] == []


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(("wrong", "right", "row", "budget"), LANGEVIN)
def test_a_planted_solver_is_refuted_and_its_twin_verified(wrong, right, row, budget):
    """The row that tells a mistake is refuted for the wrong solver, and verified for the right one."""
    found = verdicts([solver(wrong), solver(right)], "harmonic-langevin", budget)

    assert found[wrong, *row] == "refuted"
    assert found[right, *row] == "verified"
    assert "refuted" not in {verdict for (name, *_), verdict in found.items() if name == right}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("own-euler", "ou"),
        ("own-euler", "gbm"),
        ("own-euler", "harmonic-langevin"),
        ("own-platen", "ou"),
        ("own-platen", "harmonic-langevin"),
        ("own-baoab", "harmonic-langevin"),
    ],
)
def test_right_solvers_are_refuted_as_often_as_the_level_says(name, label):
    """Of 20 seeds, a claim or check of a right solver is refuted on two at most.

    The probability of any false refutation is 1 per cent a run: of three or more in twenty it is 0.001.
    """
    found = [verdicts([solver(name)], label, replace(SMALL, seed=seed)) for seed in range(1, 21)]
    assert sum("refuted" in each.values() for each in found) <= 2


@pytest.mark.slow
@pytest.mark.parametrize(("wrong", "right", "row", "budget"), LANGEVIN)
def test_planted_solvers_are_refuted_on_nearly_all_seeds(wrong, right, row, budget):
    """On 10 further seeds, the row that tells a mistake is refuted on 9 at least."""
    budgets = [replace(budget, seed=seed) for seed in range(1, 11)]
    found = [verdicts([solver(wrong)], "harmonic-langevin", each) for each in budgets]
    assert sum(each[wrong, *row] == "refuted" for each in found) >= 9


def test_the_same_seed_gives_the_same_rows():
    """A run is determined by its seed, whatever else has been run."""
    first, second = (rows([solver("own-euler")], "ou", SMALL)[0] for _ in range(2))

    assert [row.finding for row in first] == [row.finding for row in second]


def test_a_reference_stands_for_a_mean_that_is_not_known():
    """The means of the double well's reference are within five standard errors of those of fine steps of Euler's."""
    problem = spec("double-well").build()
    known = references(problem.with_moment_equations, "weak", ("x^2",), Source(1, "double-well", 0, 2**13))["x^2"]
    found = solver("own-euler").run(problem, problem.horizon / 512, problem.horizon, 2**13, 5).state["x"][0] ** 2

    off = abs(known.mean.mean() - found.mean())
    assert off < 5.0 * (known.mean.var(ddof=1) / 20 + found.var() / 2**13) ** 0.5 + 1.0 / 512
    assert 0.0 < known.bias < 1e-3


def test_a_claim_is_judged_against_a_reference():
    """On the double well, whose means at T are not known, a bound is verified, and refuted for half of the drift."""
    steps = (16, 32, 64)
    within = (Claim(measure="weak", value="unbiased", bound=0.03, quantities=("x^2",), source="made up"),)

    def bounded(name, run):
        return sealed(name, within, steps=steps)(run)

    right = bounded("bounded", solver("own-euler").run)
    wrong = bounded("bounded-half", solver("planted-half-drift").run)
    found = verdicts([right, wrong], "double-well", Budget(paths=2**17, looks=2))

    assert found["bounded", "weak", "x^2"] == "verified"
    assert found["bounded-half", "weak", "x^2"] == "refuted"


def test_a_stationary_run_is_sixteen_relaxation_times_long():
    """Stationary means are taken after 16 relaxation times, in a whole number of steps of each size."""
    problem = spec("harmonic-langevin").build()
    (plan,) = (each for each in plans(solver("own-euler"), problem, (4, 8, 16)) if each.measure == "invariant")

    assert 16.0 * problem.relaxation_time <= plan.T
    assert np.allclose(plan.T / plan.h, np.round(plan.T / plan.h), rtol=1e-12, atol=0.0)
    assert "L q p" in plan.names
