"""Marks of whose code runs, so that a process that hangs or dies can be blamed on somebody."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

# In place of the index of a scheme: the problem itself, with its truth.
PROBLEM = -1
# In place of the index of a measure: none of them, but the scheme.
NO_MEASURE = -1


@contextmanager
def alone() -> Iterator[None]:
    """End a copy of this process that the code inside has made by ``fork``: one alone comes back."""
    process = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != process:
            os._exit(1)


class Marker:
    """Is told whose code runs, and sets it no limits."""

    @contextmanager
    def of(self, lane: int) -> Iterator[None]:  # noqa: ARG002 - nobody is watched here
        """Run code of a scheme, by its index among those of the block, or of the problem."""
        with alone():
            yield

    @contextmanager
    def measure(self, index: int) -> Iterator[None]:  # noqa: ARG002
        """Run code of a measure, by its index among those put to the scheme."""
        yield
