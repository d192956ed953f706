"""The declaration of an experiment."""

import pytest

from facade import Budget, Exhibit, Experiment, FineRun, MeanTable, Note, Printed, Row, SchemeRun
from sdaeverify import ProblemError


def row(steps=8, problem="gbm", **other):
    return Row(problem=problem, scheme="milstein", steps=steps, observable="x", **other)


def experiment(*rows):
    return MeanTable(name="mine", title="made up", source="nowhere", rows=rows)


@pytest.mark.parametrize(
    ("digits", "value", "half"), [("2.00934", 2.00934, 5e-6), ("2.", 2.0, 0.5), ("1.2e-3", 1.2e-3, 5e-5)]
)
def test_printed_digits(digits, value, half):
    """A printed number knows its value and half a unit of its last digit."""
    printed = Printed(digits, 10)

    assert printed.value == value
    assert printed.half_unit == pytest.approx(half, rel=1e-12)


@pytest.mark.parametrize(("digits", "paths"), [("two", 10), ("", 10), ("nan", 10), ("2.0", 0)])
def test_printed_nonsense(digits, paths):
    """What is no number, or the mean of nothing, is refused in one line."""
    with pytest.raises(ProblemError, match=r"^a printed [^\n]*, got [^\n]*$"):
        Printed(digits, paths)


def test_steps_of_a_problem():
    """Steps on one problem are the least times powers of 2; on different ones they are independent."""
    experiment(row(6), row(24), row(7, "ou"))
    with pytest.raises(ProblemError, match=r"steps on gbm must be the least times powers of 2, got \[6, 18\]"):
        experiment(row(6), row(18))
    experiment(row(6), row(12, reference=FineRun("milstein", 48)))
    with pytest.raises(ProblemError, match=r"steps on gbm must be the least times powers of 2, got \[12, 9, 18\]"):
        experiment(row(12), row(9, reference=FineRun("milstein", 18)))


@pytest.mark.parametrize(
    ("steps", "other", "message"),
    [
        (0, {}, "a row needs at least 1 step, got 0"),
        (8, {"at": 0}, "a mean must be taken after 1 to 8 steps, got 0"),
        (8, {"at": 9}, "a mean must be taken after 1 to 8 steps, got 9"),
        (8, {"reference": FineRun("milstein", 8)}, "steps of a reference must be 8 times a power of 2, got 8"),
        (8, {"reference": FineRun("milstein", 24)}, "steps of a reference must be 8 times a power of 2, got 24"),
    ],
)
def test_rows_that_cannot_be_taken(steps, other, message):
    """A mean is taken after a step that is made, and its reference has shorter steps that fit."""
    with pytest.raises(ProblemError, match=f"^{message}$"):
        row(steps, **other)


def test_no_rows():
    """An experiment without rows is refused."""
    with pytest.raises(ProblemError, match="experiment 'mine' has no rows"):
        experiment()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"over": "sum"}, "over must be one of each, mean, max, got 'sum'"),
        ({"at": (0, 2)}, r"note 'n' must be taken after steps from 1 on, got \(0, 2\)"),
        ({"at": ()}, r"note 'n' must be taken after steps from 1 on, got \(\)"),
    ],
)
def test_notes_that_cannot_be_taken(options, message):
    """A note says when it is taken and how it is put together."""
    with pytest.raises(ProblemError, match=f"^{message}$"):
        Note("n", "x", **options)


@pytest.mark.parametrize(
    ("steps", "at", "message"),
    [
        (0, None, "a run needs at least 1 step, got 0"),
        (4, (2, 5), r"note 'n' must be taken after 1 to 4 steps, got \(2, 5\)"),
    ],
)
def test_runs_that_cannot_be_made(steps, at, message):
    """A run makes a step, and its notes are taken on the way."""
    with pytest.raises(ProblemError, match=f"^{message}$"):
        SchemeRun(problem="gbm", scheme="milstein", steps=steps, notes=(Note("n", "x", at),))


class Nothing(Experiment):
    """An experiment of nothing."""

    name, title, source, paths = "n", "t", "s", 10

    def work(self, budget):
        return {}

    def exhibit(self, evidence):
        return Exhibit(())


class More(Nothing):
    """The same with more paths where there is time."""

    full_paths = 90


def test_paths_of_a_budget():
    """A full budget has as many paths as it says, and those of the small one where it says nothing."""
    few, many = Nothing(), More()

    assert [each.paths_of(budget) for each in (few, many) for budget in Budget] == [10, 10, 10, 90]
