"""What tests of studies share."""

from contextlib import ExitStack

import pytest

from .fragile import Fragile


@pytest.fixture
def fragile():
    """Return a function that makes worker processes that die."""
    with ExitStack() as opened:
        yield lambda *given, **named: opened.enter_context(Fragile(*given, **named))
