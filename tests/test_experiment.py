"""The declaration of an experiment."""

import pytest

from sdaeverify import FineRun, MeanTable, Printed, ProblemError, Row


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


def test_when_a_mean_is_taken():
    """It is taken after all steps unless fewer are named."""
    assert (row(8).steps_made, row(8, at=3).steps_made) == (8, 3)


def test_no_rows():
    """An experiment without rows is refused."""
    with pytest.raises(ProblemError, match="experiment 'mine' has no rows"):
        experiment()


def test_empty_blocks():
    """Blocks without paths are refused."""
    with pytest.raises(ProblemError, match="experiment 'mine': a block needs at least 1 path, got 0"):
        MeanTable(name="mine", title="made up", source="nowhere", rows=(row(),), block=0)
