"""Errors in one line: what was raised, and where in the code of a plugin."""

from dataclasses import replace

import numpy as np

from facade import delay_linear, one_line
from sdaeverify import UsageError
from sdaeverify.errors import with_traceback
from sdaeverify.numerics import apply

CALL = """
def call(function):
    try:
        function()
    except Exception as error:
        return error
"""


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


def test_a_traceback_begins_in_the_plugin():
    """Calls of the framework that lead to it are left out; without a plugin, nothing is."""
    framework = {"__name__": "sdaeverify.made_up"}
    exec(compile(CALL, "made_up.py", "exec"), framework)

    def broken():
        raise ValueError("of a plugin")

    assert "made_up.py" not in with_traceback(framework["call"](broken))
    assert "in broken" in with_traceback(framework["call"](broken))
    assert "made_up.py" in with_traceback(framework["call"](None))


def test_what_is_meant_for_the_user_needs_no_line():
    """A message of the framework says itself what is wrong."""

    def refuse():
        raise UsageError("no such thing")

    assert one_line(raised(refuse)) == "no such thing"


def test_what_no_plugin_has_raised_has_no_line():
    """Where no code of a plugin was run, none is accused."""
    assert one_line(ValueError("made, and never raised")) == "ValueError: made, and never raised"


def test_a_call_with_wrong_arguments_is_told_with_the_right_ones():
    """Of a method of a problem, and of a function that a problem was given; nothing else that is raised has any."""

    class Equation:
        def __init__(self):
            self.drift = drift

        def diffused(self, t, x, v, y, w):
            return w

    def drift(t, x):
        return x

    problem = Equation()
    for call, expected in (
        (lambda problem=problem: problem.diffused(0.0, 1.0, 2.0), "Equation.diffused(t, x, v, y, w)"),
        (lambda problem=problem: problem.diffused(1, 2, 3, 4, 5, 6), "Equation.diffused(t, x, v, y, w)"),
        (lambda problem=problem: problem.drift(0.0, 1.0, 2.0), "Equation.drift(t, x)"),
        (lambda problem=problem: problem.drift(0.0, z=1.0), "Equation.drift(t, x)"),
    ):
        assert f"; expected {expected} (" in one_line(raised(call))
    for other in (lambda: int("a"), lambda: len(3), drift, lambda: None + 1):
        assert "expected Equation" not in one_line(raised(other))


def test_the_signature_of_a_form_is_told():
    """The step of a scheme for delay equations that forgets the past reads what its form expects."""
    problem = delay_linear()
    told = one_line(raised(lambda problem=problem: problem.diffused(0.0, 1.0, 2.0)))
    assert "; expected DelaySDAE.diffused(t, x, v, y, w)" in told


def test_a_constructor_is_not_explained_by_the_one_of_another_object():
    """A missing argument of a constructor is not followed by the arguments of a local object's constructor."""

    class Truth:
        def __init__(self, start):
            self.start = start

    class Equation:
        def __init__(self, drift, *, horizon):
            self.drift, self.horizon = drift, horizon

    def build():
        truth = Truth(0.0)
        return Equation(truth.start)

    told = one_line(raised(build))
    assert "horizon" in told
    assert "expected" not in told


def test_a_lambda_with_wrong_arguments_is_told_by_the_call_of_the_framework():
    """An observable without the argument t is named, because the name of a lambda does not say what it is."""
    told = one_line(
        raised(lambda: replace(delay_linear(), truths=(), observables={"x": lambda parts: parts["x"][0]}))
    )
    assert "; called as observable(0.0, initial) (" in told
