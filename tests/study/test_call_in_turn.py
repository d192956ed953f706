"""Calls of programs on any workers, with values in the order of the arguments."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from facade import load_registry
from sdaeverify import UsageError
from sdaeverify.studying import call_in_turn

REGISTRY = load_registry(environ={})


def square(x):
    """Return x^2."""
    return x * x


def named(*numbers):
    """Yield arguments with their names."""
    yield from ((f"number {n}", n) for n in numbers)


@pytest.mark.parametrize("jobs", [1, 3])
def test_values_come_in_the_order_of_the_arguments(jobs):
    """With one job in this process, else on the threads of an executor."""
    with ThreadPoolExecutor(jobs) as threads:
        executor = threads if jobs > 1 else None
        assert [*call_in_turn(square, named(3, 1, 2), REGISTRY, jobs, executor)] == [(3, 9), (1, 1), (2, 4)]


def test_arguments_are_read_as_values_are_taken():
    """A program can end after any value: no argument is asked for in advance by one job."""
    asked = []

    def arguments():
        for n in range(5):
            asked.append(n)
            yield f"number {n}", n

    values = call_in_turn(square, arguments(), REGISTRY, 1)
    assert next(values) == (0, 0)
    assert asked == [0]
    values.close()


def test_an_argument_that_cannot_be_sent_is_named():
    """Its name and the remedy are one line."""
    with ThreadPoolExecutor(2) as threads, pytest.raises(UsageError, match="scheme mine cannot be sent"):
        [*call_in_turn(square, [("scheme mine", lambda: 0)], REGISTRY, 2, threads)]
