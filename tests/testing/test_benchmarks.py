"""Benchmarks of the kit, and what the plugin of pytest says of its tests."""

import json

import pytest

from sdaeverify import UsageError
from sdaeverify.testing import parametrize_with_benchmarks
from sdaeverify.testing.benchmarks import StepTiming

TESTS = """
import pytest
from sdaeverify.testing import parametrize_with_benchmarks, parametrize_with_checks


@parametrize_with_benchmarks(["milstein"], problems=["gbm"], paths=[256])
def test_speed(benchmark, timing):
    timing(benchmark)


@parametrize_with_checks(["milstein"], problems=["gbm"])
def test_kit(subject, check):
    check(subject)


def test_other():
    pass
"""


class Timed:
    """A benchmark that calls what it is given once."""

    def __init__(self):
        self.group, self.extra_info, self.calls = "", {}, 0

    def __call__(self, task):
        self.calls += 1
        return task()


def test_each_scheme_is_timed_on_few_and_on_many_paths():
    """A case for each number of paths, on one problem of the scheme's own form, with the marker benchmark."""
    cases = parametrize_with_benchmarks(["milstein", "half-explicit-euler"]).args[1]
    timings = [timing for case in cases for timing in case.values]

    assert [(each.cell.scheme.label, each.paths) for each in timings] == [
        (name, paths) for name in ("half-explicit-euler", "milstein") for paths in (256, 4096)
    ]
    assert {mark.name for case in cases for mark in case.marks} == {"benchmark"}
    assert all(isinstance(each, StepTiming) for each in timings)


def test_a_ratio_is_that_of_two_steps():
    """Euler's own step costs about one of itself, and a scheme with more evaluations costs more."""
    euler, milstein = (parametrize_with_benchmarks([name], ["gbm"]).args[1][-1].values[0]
                       for name in ("euler-maruyama", "platen-weak-2"))  # fmt: skip
    benchmark = Timed()
    ratio = euler(benchmark)

    assert 0.2 < ratio < 5.0
    assert milstein(Timed()) > ratio
    assert benchmark.calls == 1
    assert benchmark.group == "gbm, 4096 paths"
    assert benchmark.extra_info == {"scheme": "euler-maruyama", "problem": "gbm", "ratio": ratio}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([],), "schemes is empty"),
        ((["nobody"],), "unknown scheme 'nobody'"),
        ((["milstein"], ["gbm"], [0]), "paths expects positive numbers, got 0"),
        ((["milstein"], ["pendulum"]), "cannot solve problem"),
    ],
)
def test_what_cannot_be_timed_is_told(arguments, message):
    """When the tests are collected, in one line."""
    schemes, problems, paths = (*arguments, None, (256,))[:3]
    with pytest.raises(UsageError, match=message):
        parametrize_with_benchmarks(schemes, problems, paths=paths or (256,))


@pytest.mark.slow
@pytest.mark.long
def test_the_report_has_a_section(pytester, monkeypatch):
    """Markers need no registration; tests of the kit are counted by part and outcome, also of several workers."""
    # Benchmarks are off in a worker of xdist, of which the runs below would seem to be part.
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    pytester.makepyfile(TESTS)
    arguments = ("--strict-markers", "-q", "-p", "no:cacheprovider")
    for workers in ((), ("-n", "2")):
        told = pytester.runpytest_subprocess(*arguments, *workers)
        told.assert_outcomes(passed=24)
        told.stdout.fnmatch_lines(["*= sdaeverify =*", "checks: 22 passed", "timings: 1 passed"])

    chosen = pytester.runpytest_subprocess(*arguments, "-m", "sdaeverify and not benchmark")
    chosen.assert_outcomes(passed=22, deselected=2)
    pytester.runpytest_subprocess(*arguments, "-m", "benchmark", "--benchmark-json", "speed.json")
    (timed,) = json.loads((pytester.path / "speed.json").read_text())["benchmarks"]
    assert timed["extra_info"]["scheme"] == "milstein"
    assert timed["extra_info"]["ratio"] > 0.0


def test_other_runs_of_pytest_have_no_section(pytester):
    """Nothing is said where no test is of the kit."""
    pytester.makepyfile("def test_other(): pass")
    assert "sdaeverify =" not in pytester.runpytest_subprocess("-q").stdout.str()
