"""Hunts as tests of a project."""

import pytest

from facade import EulerMaruyama
from sdaeverify import Step, UsageError
from sdaeverify_hunt import parametrize_with_hunts

FAST = {"measures": "strong", "forms": ["SDE"], "shrinking": 1.0}


class Pushed(EulerMaruyama):
    """x+ = x + h (f(t, x) + x/5) + B(t, x) dW."""

    name = "pushed"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return Step(super().step(problem, state, t, h, noise).state + 0.2 * h * state)


def cases(*schemes, **options):
    """Return the parameters of a test of some schemes."""
    return parametrize_with_hunts(schemes, **FAST, **options).args[1]


@pytest.mark.long
def test_a_wrong_scheme_fails_with_its_counterexample():
    """The message says which claim fails, and is the plugin file that shows it."""
    ((scheme, check),) = (case.values for case in cases(Pushed(), examples=40))

    with pytest.raises(AssertionError, match=r"strong, SDE: .* is refuted by example") as caught:
        check(scheme)
    assert "sdaeverify_problems" in str(caught.value)


@pytest.mark.long
def test_a_right_scheme_passes():
    """Nothing is raised where nothing is found."""
    ((scheme, check),) = (case.values for case in cases("milstein", examples=4))

    check(scheme)


def test_each_scheme_is_a_test_with_the_marker():
    """Patterns and schemes are mixed, and a project leaves hunts out by the marker."""
    found = cases(EulerMaruyama(), "mil*")

    assert [case.id for case in found][:2] == ["euler-maruyama", "milstein"]
    assert {mark.name for case in found for mark in case.marks} == {"hunt"}
    assert all(case.values[1].options["minutes"] == 0.5 for case in found)


@pytest.mark.parametrize(
    ("options", "what"), [({"minuts": 1}, "unknown option minuts"), ({"minutes": 0}, "positive")]
)
def test_a_wrong_option_is_told_when_tests_are_collected(options, what):
    """No test has to run for it."""
    with pytest.raises(UsageError, match=what):
        cases("milstein", **options)


@pytest.mark.parametrize(("schemes", "what"), [((), "schemes is empty"), (("nosuch",), "unknown scheme")])
def test_a_hunt_of_nothing_is_refused(schemes, what):
    """One line says what was expected."""
    with pytest.raises(UsageError, match=what):
        cases(*schemes)
