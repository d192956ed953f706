"""What is shipped is right and what is planted is wrong: each by the line of defence that is meant for it."""

from typing import ClassVar

import numpy as np
import pytest

from adaptive.solving import GBM, path, problem, sample, solver, verdicts
from sdaeverify import SchemeError
from sdaeverify.studying import Source
from sdaeverify_adaptive import TICKS, Solved, brownian_path
from sdaeverify_adaptive.checks import KEEPS_ITS_PATH, OWN_STEPS, check
from sdaeverify_adaptive.marching import powers, rounded
from sdaeverify_adaptive.sample import Budget, checked, fixed, measure, why_not
from sdaeverify_adaptive.solvers.embedded import HeunPI
from sdaeverify_schemes.heun import Heun

pytestmark = pytest.mark.long

RIGHT = [
    *((name, label) for name in ("euler-previsible", "heun-nested") for label in (GBM, "ou", "heisenberg", "shear")),
    *((name, label) for name in ("heun-pi", "milstein-pi") for label in (GBM, "ou")),
]
# By what is measured along paths.
WRONG = [
    ("planted-blind", "ou"),
    ("planted-floor", "ou"),
    ("planted-peek", "gbm[a=0.1,b=0.3]"),
    ("planted-redraw", "ou"),
    ("planted-redraw-law", "ou"),
    ("planted-skip", "heisenberg"),
    ("planted-skip-mixed", "shear"),
]
QUICK = ("planted-blind",)
# By a check, on every path.
CHECKED = [
    ("planted-batch-norm", OWN_STEPS),
    ("planted-redraw", KEEPS_ITS_PATH),
    ("planted-wide-bridge", KEEPS_ITS_PATH),
]
SEEDS = range(1, 21)


def failed(name, label=GBM, seed=1):
    """Return the checks that a solver fails."""
    made = path(problem(label).noise_dim, seed=seed, label=label)
    return {each.check for each in check(solver(name), problem(label), made, 2.0**-8) if each.failed}


@pytest.mark.parametrize(("name", "label"), [("heun-pi", "ou"), ("euler-previsible", "ou")])
def test_a_right_solver_is_not_refuted(name, label):
    """With coarse tolerances and few paths, no claim of a shipped solver is refuted."""
    assert "refuted" not in verdicts(sample(name, label, 100, tolerances=(2**-4, 2**-6, 2**-8))).values()


@pytest.mark.parametrize(("name", "label"), [pair for pair in WRONG if pair[0] in QUICK])
def test_a_planted_solver_is_refuted(name, label):
    """Planted bugs that cost little are refuted on 400 paths."""
    assert "refuted" in verdicts(sample(name, label)).values()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "label"), RIGHT)
def test_right_solvers_are_refuted_on_no_seed(name, label):
    """On 17 seeds and 400 paths, no claim of a right solver is refuted."""
    assert [seed for seed in SEEDS[:17] if "refuted" in verdicts(sample(name, label, seed=seed)).values()] == []


@pytest.mark.slow
@pytest.mark.parametrize(("name", "label"), WRONG)
def test_planted_solvers_are_refuted_on_nearly_all_seeds(name, label):
    """On at least 19 of 20 seeds with 400 paths each, a claim of a planted solver is refuted."""
    assert sum("refuted" in verdicts(sample(name, label, seed=seed)).values() for seed in SEEDS) >= 19


@pytest.mark.parametrize(("name", "which"), CHECKED)
def test_checks_tell_what_paths_cannot(name, which):
    """Steps that are shared and noise that is not the path's are told by their check, and by no other."""
    assert failed(name) == {which}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "which"), CHECKED)
def test_checks_fail_on_every_seed(name, which):
    """The two checks have no luck: they tell on each of 20 seeds."""
    assert all(failed(name, seed=seed) == {which} for seed in SEEDS)


@pytest.mark.parametrize("name", ["euler-previsible", "heun-nested", "heun-pi", "milstein-pi"])
def test_shipped_solvers_pass_the_checks(name):
    """They have their own steps and keep their path."""
    assert failed(name) == set()


@pytest.mark.slow
def test_without_the_limit_the_mixed_skip_survives():
    """A test of the test: with the rate alone, the solver whose mean error stays is not refuted."""
    measured = [sample("planted-skip-mixed", "shear", seed=seed) for seed in SEEDS[:5]]

    assert all("refuted" in verdicts(each).values() for each in measured)
    assert all("refuted" not in verdicts(each, with_limit=False).values() for each in measured)


def test_a_nested_mesh_passes_over_no_time_that_was_seen():
    """Whatever end a rejected step has had, the solver stops there."""
    made = path(2, label="shear")
    asked = []

    class Watched(type(made)):
        def at(self, tick):
            asked.append(np.broadcast_to(tick, (self.paths,)).copy())
            return super().at(tick)

    watched = Watched(made.source, made.horizon, made.W, made.J, made.rows[:1])
    found = solver("heun-nested").solve(problem("shear"), watched, 2.0**-6)
    assert found.rejected[0] > 0
    assert {int(tick[0]) for tick in asked} == set(found.times[:, 0].tolist())


def test_a_path_without_time_to_reject_is_met_exactly():
    """On dx = x_1 o dW the solver ends at T, having made steps of whole ticks."""
    found = solver("heun-pi").solve(problem("ou"), path(label="ou"), 2.0**-6)

    assert np.all(found.times[-1] == TICKS)
    assert np.all(found.evaluations == 2 * (found.steps + found.rejected))


def test_lengths_have_few_bits():
    """Lengths are rounded down, to four leading bits or to one."""
    sizes = np.array([1.0, 17.0, 1023.0, 999_999.0])

    assert rounded(sizes).tolist() == [1, 16, 960, 983040]
    assert powers(sizes).tolist() == [1, 16, 512, 524288]


def test_fixed_steps_run_on_the_same_path():
    """Heun's scheme with 256 fixed steps is nearer to the adaptive solver on this path than on another one."""
    made, other = path(label=GBM), path(label=GBM, seed=2)
    one = solver("heun-pi").solve(problem(GBM), made, 2.0**-10).state
    same, else_ = (fixed(Heun(), problem(GBM), each, 256) for each in (made, other))

    assert np.abs(one - same).max() < 0.05 < np.abs(one - else_).max()


@pytest.mark.parametrize(
    ("name", "label", "why"),
    [
        ("milstein-pi", "shear", "not scalar"),
        ("heun-pi", "noncommuting", "no solution is known"),
        ("heun-pi", "growing-volatility", ""),
    ],
)
def test_what_cannot_be_measured_is_said(name, label, why):
    """A solver that refuses, and a problem without a truth on a path, are named; coefficients may depend on time."""
    assert why in why_not(solver(name), problem(label))
    assert bool(why) == bool(why_not(solver(name), problem(label)))


def test_what_is_no_solution_is_refused():
    """A solver that returns a bare state, or one of another number of paths, breaks its contract."""
    state = np.zeros((1, 3))

    with pytest.raises(SchemeError, match="expected Solved"):
        checked(solver("heun-pi"), state, 3)
    with pytest.raises(SchemeError, match=r"expected \(d, 4\)"):
        checked(solver("heun-pi"), Solved(state, 1, 0, 1), 4)


class InGroups(HeunPI):
    """A solver that counts with how many rows it is asked."""

    name: ClassVar[str] = "in-groups"
    in_batches: ClassVar[bool] = True

    def solve(self, problem, path, tolerance):
        return Solved(path.rows[None] * 1.0, path.paths, 0, 1)


def test_batches_are_the_unit_where_rows_share_their_steps():
    """A solver in batches is given the rows of one group at a time, and its ends are put back in their order."""
    found = measure(InGroups(), problem("ou"), Budget(40, (0.1, 0.05, 0.02), 1), "ou")

    assert np.array_equal(found.runs.ends[0, 0], np.arange(40))
    assert np.all(found.runs.steps == 2)


def test_who_says_that_rows_share_their_steps_is_not_asked_for_own_ones():
    """A solver in batches is let off the check of own steps; one that couples its rows unsaid fails it."""
    own, _ = check(InGroups(), problem("ou"), path(), 2.0**-8)
    undeclared, _ = check(solver("planted-batch-norm"), problem("ou"), path(), 2.0**-8)

    assert (own.failed, own.skipped) == (
        "",
        "the solver declares that a batch shares its steps (in_batches)",
    )
    assert undeclared.failed


def test_a_single_step_is_refused():
    """An adaptive solver is no scheme of one step."""
    with pytest.raises(SchemeError, match="adaptive solver, which has no method for a single step"):
        solver("heun-pi").step(problem("ou"), np.zeros((1, 1)), 0.0, 0.1, None)


@pytest.mark.parametrize("label", ["heisenberg", "shear"])
def test_areas_have_their_moments(label):
    """The mean of x_3 and of its square is that of the paths, within five standard errors of 100."""
    seen = problem(label)
    made = brownian_path(Source(1, label, 0, 100), 2, 1.0)
    x = fixed(Heun(), seen, made, 64)
    for truth in seen.truths[1:]:
        values = seen.observe(truth.observable, 1.0, {"x": x})
        assert abs(values.mean() - truth.value(1.0)) < 5 * values.std() / 10
