"""Whose code runs: told to a guard, so that a process that hangs or dies can be blamed on somebody."""

from collections.abc import Iterator
from contextlib import contextmanager

# In place of the index of a scheme: the problem itself, with its truth.
PROBLEM = -1
# In place of the index of a measure: none of them, but the scheme.
NO_MEASURE = -1


class Guard:
    """Is told whose code runs, and does nothing about it."""

    @contextmanager
    def of(self, lane: int) -> Iterator[None]:  # noqa: ARG002 - nobody is watched here
        """Run code of a scheme, by its index among those of the block, or of the problem."""
        yield

    @contextmanager
    def measure(self, index: int) -> Iterator[None]:  # noqa: ARG002
        """Run code of a measure, by its index among those put to the scheme."""
        yield
