"""`parametrize_with_checks`: one test a check, readable names, strict expected failures, skips with reasons."""

from pathlib import Path

import pytest

import sdaeverify.testing
from sdaeverify import UsageError
from sdaeverify.testing import checks, parametrize_with_checks

FILE = """
from dataclasses import dataclass
from sdaeverify.testing import parametrize_with_checks
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_problems.gbm import gbm

EXPECTED = [{"check": "source", "reason": "a present"}, {"check": "label", "reason": "why?"}]

@dataclass(frozen=True)
class Anonymous(EulerMaruyama):
    '''A scheme from nowhere.'''
    name = "anonymous"
    source = ""
    claims = ()

@parametrize_with_checks([Anonymous(), gbm], problems=["ou"])
def test_conformance(subject, check):
    check(subject)

@parametrize_with_checks([Anonymous()], problems=["ou"], expected_failures=EXPECTED)
def test_expected(subject, check):
    check(subject)
"""


def test_a_test_file_of_the_kit(pytester):
    """A check that fails fails its test, unless that is expected; one that passes by surprise fails it, too."""
    pytester.makepyfile(test_mine=FILE)
    result = pytester.runpytest_inprocess("-rA", "-p", "no:cacheprovider", "-k", "source or label")
    out = result.stdout.str()

    result.assert_outcomes(passed=3, failed=2, xfailed=1)
    assert "anonymous fails source: its class variable source is empty" in out
    assert "FAILED test_mine.py::test_conformance[anonymous-source]" in out
    assert "PASSED test_mine.py::test_conformance[gbm-source]" in out
    assert "XFAIL test_mine.py::test_expected[anonymous-source] - a present" in out
    assert "FAILED test_mine.py::test_expected[anonymous-label]" in out
    assert "[XPASS(strict)] why?" in out


def test_parameters_are_made_without_asking_anything():
    """There is one parameter for each check, on each problem, with the subject as it was given."""
    mark = parametrize_with_checks(["euler-maruyama", "gbm"], problems=["ou"])
    names, parameters = mark.args

    assert names == ("subject", "check")
    assert len(parameters) == len(checks("scheme")) + len(checks("problem"))
    assert [parameter.values[0] for parameter in parameters[:1]] == ["euler-maruyama"]
    assert {parameter.id for parameter in parameters} >= {"euler-maruyama-paths-alone-on-ou", "gbm-moments-rate"}


def test_what_has_nothing_to_ask_is_skipped():
    """A check that cannot solve its subject skips the test with the reason."""
    (check,) = [p.values[1] for p in parametrize_with_checks(["gbm"]).args[1] if p.id == "gbm-constraints-kept"]

    with pytest.raises(pytest.skip.Exception, match="no constraint"):
        check("gbm")


@pytest.mark.parametrize("expected", [["finite"], "finite", 5, {5: "five"}, {"finite": "why"}])
def test_expected_failures_that_are_no_mappings(expected):
    """Whatever they are, it is one line that says what is expected."""
    with pytest.raises(
        UsageError, match="expected_failures expects a sequence of mappings, each with a reason, got "
    ):
        parametrize_with_checks(["gbm"], expected_failures=expected)


def test_the_kit_needs_no_pytest():
    """No module of the kit imports pytest but where its decorators are used."""
    folder = Path(sdaeverify.testing.__file__).parent
    lines = [line for file in folder.glob("*.py") for line in file.read_text(encoding="utf-8").splitlines()]

    assert any(line.strip().startswith("import pytest") for line in lines)
    assert not [line for line in lines if line.startswith(("import pytest", "from pytest"))]
