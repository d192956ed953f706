"""The declaration of an experiment."""

import pytest

from sdaeverify import Experiment, Printed, ProblemError, Row


def row(steps=8, problem="gbm"):
    return Row(problem=problem, scheme="milstein", steps=steps, observable="x")


def experiment(*rows):
    return Experiment(name="mine", title="made up", source="nowhere", rows=rows)


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
    with pytest.raises(ProblemError, match="steps on gbm"):
        experiment(row(0))


def test_no_rows():
    """An experiment without rows is refused."""
    with pytest.raises(ProblemError, match="experiment 'mine' has no rows"):
        experiment()
