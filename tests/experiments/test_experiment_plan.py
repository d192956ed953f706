"""Planning of experiments: labels, budget, order of the blocks."""

import pytest

from experiments.running import planned_run
from facade import Budget, Exhibit, Experiment, Row, SchemeRun, SharedNoise, experiment_plan
from sdaeverify import UsageError


def row(problem="gbm", scheme="milstein", steps=4, **attributes):
    return Row(problem=problem, scheme=scheme, steps=steps, observable="x", **attributes)


def test_rows_of_a_problem_are_run_together(planned):
    """Rows of one problem share their noise wherever they stand, and the table keeps the experiment's order."""
    rows = (row(), row("ou"), row(scheme="euler-maruyama", steps=8))
    plan = planned(*rows).plan

    assert [task.label for task, _ in plan.groups] == ["gbm", "ou"]
    assert [key for _, keys in plan.groups for key in keys] == [
        ("gbm", "milstein", 4), ("gbm", "euler-maruyama", 8), ("ou", "milstein", 4),
    ]  # fmt: skip


def test_all_problems_of_a_block_come_first(planned):
    """An interrupt finds as many paths of each problem; the last block holds the rest of the paths."""
    plan = planned(row(), row("ou"), paths=1003).plan

    assert plan.sizes == (500, 500, 3)
    assert list(plan.jobs()) == [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)]


def test_costly_rows_are_asked_for(planned):
    """Rows that cost most are run on request only."""
    cheap, costly = row(), row(steps=8, costly=True)

    assert planned(cheap, costly).plan.keys == {("gbm", "milstein", 4)}
    assert planned(cheap, costly, budget=Budget.FULL).plan.keys == {("gbm", "milstein", 4), ("gbm", "milstein", 8)}


def test_unknown_experiment(registry):
    """A misspelt name is told what it was meant to be."""
    with pytest.raises(UsageError, match=r"^unknown experiment 'laurent-2022-tabel-1'; did you mean laurent"):
        experiment_plan(registry, "laurent-2022-tabel-1")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (row("gbn"), "unknown problem 'gbn'"),
        (row(scheme="milsten"), "unknown scheme 'milsten'"),
        (row(scheme="gbm*"), "gbm"),
        (row("gbm*"), r"label of one problem, got 'gbm\*'"),
    ],
)
def test_labels_that_name_nothing(planned, wrong, message):
    """A row whose scheme or problem is not registered, or not one, is refused in one line."""
    with pytest.raises(UsageError, match=message):
        planned(wrong)


def test_empty_blocks(planned):
    """Blocks without paths are refused."""
    with pytest.raises(UsageError, match="experiment 'mine': a block needs at least 1 path, got 0"):
        planned(row(), block=0)


def test_too_few_paths(planned):
    """One path has no standard error."""
    with pytest.raises(UsageError, match="paths must be at least 2"):
        planned(row(), paths=1)


class OnOneNoise(Experiment):
    """Two problems on one noise."""

    name, title, source = "mine", "t", "s"

    def __init__(self, *steps: int) -> None:
        self.steps = steps

    def work(self, budget):
        noise = SharedNoise("common", 1)
        runs = zip(("gbm", "ou"), self.steps, strict=True)
        return {
            problem: SchemeRun(problem=problem, scheme="milstein", steps=steps, noise=noise)
            for problem, steps in runs
        }

    def exhibit(self, evidence):
        return Exhibit(())


def test_runs_on_a_shared_noise(registry):
    """Runs on one noise are planned together, whatever their problems, with steps that fit."""
    ((task, keys),) = planned_run(registry, "mine", OnOneNoise(4, 8)).plan.groups
    assert (task.label, keys) == ("common", ("gbm", "ou"))
    with pytest.raises(UsageError, match=r"must be the smallest times powers of 2, got \[4, 12\]"):
        planned_run(registry, "mine", OnOneNoise(4, 12))
