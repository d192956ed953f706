"""What a self-test runs."""

import pytest

from facade import selftest_trial
from sdaeverify import UsageError

from .conftest import Bad, Good, bug


def cells(trial):
    return {(cell.scheme.label, cell.spec.label, cell.measure.name) for cell in trial.plan.cells}


def test_bugs_run_on_their_problem_and_schemes_on_all(registry_of):
    """A planted scheme meets its problem alone, a registered one all, by what they claim something about.

    There are no controls, which only take back what is verified.
    """
    trial = selftest_trial(registry_of(bug()))

    assert cells(trial) == {
        ("good", "curve", "sharp"),
        ("good", "line", "sharp"),
        ("planted-bad", "line", "sharp"),
    }
    assert {type(cell.scheme) for cell in trial.plan.cells} == {Good, Bad}
    assert not any(made.controls for made in trial.plan.problems)
    assert not trial.missing


def test_problem_with_parameters(registry_of):
    """A bug on a problem with parameters is run there, registered schemes on the problem as it is registered."""
    trial = selftest_trial(registry_of(bug(problem="line[a=2]"), bug(problem="line[a=2.0]", kind="other")))

    assert ("planted-bad", "line[a=2]", "sharp") in cells(trial)
    assert {problem for scheme, problem, _ in cells(trial) if scheme == "good"} == {"curve", "line"}
    assert len([made for made in trial.plan.problems if made.spec.name == "line"]) == 2
    assert {spec.label for spec in trial.placed.values()} == {"line[a=2]"}


def test_largest_problem_first(registry_of):
    """Problems come in the order of their numbers of cells, so that workers end together."""
    trial = selftest_trial(registry_of(bug(), bug("other")))

    assert [len(made.cells) for made in trial.plan.problems] == [3, 1]


def test_bug_on_an_unknown_problem_is_missing(registry_of):
    """A bug that cannot be run is kept, with the reason."""
    unknown = bug(problem="lime")

    trial = selftest_trial(registry_of(unknown))

    assert list(trial.missing) == [unknown]
    assert "did you mean line?" in trial.missing[unknown]


@pytest.mark.parametrize(
    ("only", "schemes"), [("planted-*", {"planted-bad"}), ("good", {"good"}), ("line", {"good", "planted-bad"})]
)
def test_only_what_matches(registry_of, only, schemes):
    """A glob selects by the name of the scheme or of the problem."""
    trial = selftest_trial(registry_of(bug()), only)

    assert {cell.scheme.name for cell in trial.plan.cells} == schemes


def test_nothing_that_matches_is_an_error(registry_of):
    """A pattern that selects nothing does not pass for a test that succeeds."""
    with pytest.raises(UsageError, match="matches 'gooseberry'"):
        selftest_trial(registry_of(bug()), "gooseberry")
