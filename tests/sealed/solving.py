"""What tests of sealed solvers share: problems, solvers, samples made of numbers, and rows of a run."""

from functools import cache

import numpy as np

from facade import load_registry
from sdaeverify.numerics import GROUPS
from sdaeverify.studying import select_problems
from sdaeverify_sealed.judging import Question, ask
from sdaeverify_sealed.references import Reference
from sdaeverify_sealed.run import SealedRun, cells
from sdaeverify_sealed.sample import Budget, Look, Plan, Sample
from sdaeverify_solvers import judge

CONFIDENCE = 0.99
H = np.array([0.25, 0.125, 0.0625])


@cache
def registry():
    return load_registry(environ={}, lab=True)


def spec(label):
    return select_problems(registry(), label)[0]


def solver(name):
    return registry().things("sdaeverify_sealed")[name]


def rows(solvers, label, budget):
    """Return the rows of some solvers on a problem, judged together, and why pairs are left out."""
    pairs, why = cells(solvers, [spec(label)], budget)
    run = SealedRun(pairs, budget)
    for _ in run.run():
        pass
    return run.rows, why


def verdicts(solvers, label, budget):
    """Return the verdicts by solver, measure and quantity."""
    found, _ = rows(solvers, label, budget)
    return {(row.cell.solver.name, row.measure, row.finding.quantity): row.finding.verdict.value for row in found}


def made(errors, se, measure="weak", seed=1, size=1.0):
    """Return a sample of the mean of x, its exact value being 0, with given errors and a standard error."""
    rng = np.random.default_rng(seed)
    values = np.array(errors)[:, None] + se * np.sqrt(GROUPS) * rng.standard_normal((len(errors), GROUPS))
    within = np.full((len(errors), GROUPS, 1), se**2 * GROUPS)
    look = Look(values[..., None], within, np.zeros((len(errors), GROUPS, 0)), np.zeros(1, dtype=bool))
    paths = min(int((size / se) ** 2 / GROUPS), 10**6)
    plan = Plan(measure, 1.0, H[: len(errors)], ("x",))
    return Sample(plan, (max(paths, 100),), (look,), {"x": Reference(np.zeros(GROUPS))})


def judged(claimant, sample, label="ou"):
    """Return the finding on the first claim of a solver that a sample covers."""
    problem = spec(label).build()
    asked = list(ask(Question(claimant, problem, problem, sample, CONFIDENCE)))
    return judge(asked, CONFIDENCE)[0]


SMALL = Budget(paths=2**15, looks=2)
