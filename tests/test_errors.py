"""Errors in one line: what was raised, and where in the code of a plugin."""

import numpy as np

from facade import one_line
from sdaeverify import UsageError
from sdaeverify.numerics import apply


def raised(function):
    """Return what a function raises."""
    try:
        function()
    except Exception as error:
        return error
    raise AssertionError


def line_of(function):
    """Return the line after the one where a function begins."""
    return function.__code__.co_firstlineno + 1


def test_the_line_is_that_of_who_called_what_raised():
    """An error inside of arrays or of the framework is told of the line that called them."""

    def of_arrays():
        np.linalg.inv(np.zeros((2, 2)))

    def of_framework():
        apply(None, None)

    for function in (of_arrays, of_framework):
        assert one_line(raised(function)).endswith(f"test_errors.py:{line_of(function)})")


def test_what_is_meant_for_the_user_needs_no_line():
    """A message of the framework says itself what is wrong."""

    def refuse():
        raise UsageError("no such thing")

    assert one_line(raised(refuse)) == "no such thing"


def test_what_no_plugin_has_raised_has_no_line():
    """Where no code of a plugin was run, none is accused."""
    assert one_line(ValueError("made, and never raised")) == "ValueError: made, and never raised"
