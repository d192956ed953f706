"""``pytest --sdaeverify``: what becomes of claimed cells as tests."""

from xml.etree import ElementTree as ET

import pytest

USAGE = pytest.ExitCode.USAGE_ERROR
EXPECTED = """
[[tool.sdaeverify.expected-failures]]
scheme = "{scheme}"
reason = "a known gap"
"""


def statuses(pytester, file):
    """Return the outcome of each test from a JUnit file."""
    cases = ET.parse(pytester.path / file).iter("testcase")
    return {f"{case.get('classname')}.{case.get('name')}": [child.tag for child in case] for case in cases}


def test_each_claimed_cell_is_a_test(project):
    """Claims that hold pass, others fail with claim, interval and command; what cannot be decided is skipped."""
    result = project("-v", "-rs")

    result.assert_outcomes(passed=1, failed=2, skipped=1)
    result.stdout.re_match_lines_random(
        [
            r"sdaeverify: claimed cells: 4, problems: 1, tier smoke, seed 20170601; policy: .*pyproject.toml",
            r"sdaeverify::gbm::right::strong PASSED.*",
            r"sdaeverify::gbm::vague::strong SKIPPED.*",
            r"SKIPPED.*undecided: vague on gbm, strong x: .*does not know what 'sometimes' means.*",
            r"refuted: wrong on gbm, strong x: claimed order >= 1.0 up to a margin of 0.2",
            r"  estimate: 0\.\d+, between 0\.\d+ and 0\.\d+ \(99 % interval\)",
            r"  reproduce: python -m sdaeverify matrix -s wrong -p gbm -m strong .*--plugin .*schemes.py",
            r"not measured: raising on gbm, strong: claimed order >= 0.5 up to a margin of 0.2",
            r"  reason: RuntimeError: out of \\x1b\[31msteps",
        ]
    )
    assert "Traceback" not in result.stdout.str()


def test_undecided_claims_fail_where_the_policy_says_so(project):
    """Undecided is as bad as refuted then."""
    result = project(schemes=["vague"], further='inconclusive = "fail"')

    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["undecided: vague on gbm, strong x: claimed sometimes*"])


@pytest.mark.parametrize("scheme", ["wrong", "vague"])
def test_expected_failures(project, scheme):
    """A claim that is expected to fail and does is no failure, and its reason is told."""
    result = project("-rx", schemes=[scheme], further=EXPECTED.format(scheme=scheme))

    result.assert_outcomes(xfailed=1)
    result.stdout.fnmatch_lines([f"XFAIL sdaeverify::gbm::{scheme}::strong - *a known gap"])


def test_a_broken_contract_is_no_expected_failure(project):
    """It fails with its reason, whatever the policy expects."""
    result = project(schemes=["breaching"], further=EXPECTED.format(scheme="breaching"))

    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        ["refuted: breaching on gbm, strong: *", "  reason: *", "  method: contract and exact*"]
    )


@pytest.mark.parametrize(("further", "outcome"), [("", "failed"), ("strict = false", "passed")])
def test_an_expected_failure_that_holds(project, further, outcome):
    """It fails, so that the expectation is taken back, unless the policy is not strict about it."""
    result = project(schemes=["right"], further=EXPECTED.format(scheme="right") + further)

    result.assert_outcomes(**{outcome: 1})
    assert ("expected to fail, but verified: right on gbm" in result.stdout.str()) == (outcome == "failed")


def test_an_expected_failure_of_nothing(project):
    """A pattern that matches no cell is told at the top: its reason may be gone, or a name misspelt."""
    result = project("--collect-only", further=EXPECTED.format(scheme="rihgt"))

    result.stdout.fnmatch_lines(["the expected failure scheme=rihgt matches no claimed cell"])


def test_collecting_runs_nothing(project):
    """The tests are listed as a tree of problems, schemes and measures."""
    result = project("--collect-only", "-q")

    assert result.outlines[:4] == [
        f"sdaeverify::gbm::{name}::strong" for name in ("raising", "right", "vague", "wrong")
    ]
    assert result.ret == pytest.ExitCode.OK


@pytest.mark.parametrize(
    ("arguments", "outcomes"),
    [
        (["-k", "right or vague"], {"passed": 1, "skipped": 1, "deselected": 2}),
        (["-m", "not sdaeverify"], {"deselected": 4}),
        (["-x"], {"failed": 1}),
    ],
)
def test_tests_are_selected_as_any_others(project, arguments, outcomes):
    """By -k and -m, and -x stops at the first failure."""
    project(*arguments).assert_outcomes(**outcomes)


def test_other_tests_run_beside(pytester, project):
    """Claims are added to the tests that are found in files."""
    pytester.makepyfile(test_other="def test_it(): pass")

    project(schemes=["right"]).assert_outcomes(passed=2)


@pytest.mark.parametrize("other", ["", "def test_it(): pass"])
def test_nothing_to_test_is_an_error(pytester, project, other):
    """Whether other tests pass or there are none, a run without a claim fails and says why."""
    pytester.makepyfile(test_other=other)
    result = project(further='measures = ["stability"]')

    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    result.stdout.fnmatch_lines(["ERROR: --sdaeverify: nothing to test: no scheme of the policy claims anything*"])


@pytest.mark.parametrize(
    ("arguments", "further", "words"),
    [
        (
            ["--sdaeverify-tier", "smok"],
            "",
            "tier must be one of smoke, ci, nightly, got 'smok'; did you mean smoke?",
        ),
        (["--sdaeverify-seed", "-1"], "", "seed must be between 0 and 2^63 - 1, got -1"),
        ([], "sheme = 1", "unknown key 'sheme'"),
        ([], 'measures = ["stong"]', "unknown measure 'stong'; did you mean strong?"),
    ],
)
def test_what_a_user_gets_wrong(project, arguments, further, words):
    """It is one line and pytest's code of wrong usage; nothing is run."""
    result = project(*arguments, further=further)

    assert result.ret == USAGE
    (line,) = [line for line in result.errlines if line.startswith("ERROR: --sdaeverify: ")]
    assert words in line
    assert "Traceback" not in result.stderr.str() + result.stdout.str()


def test_a_broken_plugin_that_is_asked_for(pytester):
    """A plugin file that cannot be loaded is wrong usage, and named."""
    pytester.makepyfile(broken="raise RuntimeError('two\\nlines')")
    pytester.makepyprojecttoml('[tool.sdaeverify]\nplugins = ["broken.py"]\n')
    result = pytester.runpytest_inprocess("--sdaeverify", "-p", "no:hypothesispytest")

    assert result.ret == USAGE
    result.stderr.fnmatch_lines(["ERROR: --sdaeverify: plugin file *broken.py: RuntimeError: two lines (broken*"])


def test_junit_file(pytester, project):
    """The JUnit file has a case for each cell, by problem, scheme and measure."""
    project("--junitxml=junit.xml")

    assert statuses(pytester, "junit.xml") == {
        "sdaeverify.gbm.right.strong": [],
        "sdaeverify.gbm.wrong.strong": ["failure"],
        "sdaeverify.gbm.vague.strong": ["skipped"],
        "sdaeverify.gbm.raising.strong": ["failure"],
    }


def test_options_beat_the_policy(project):
    """Tier and seed can be given for a run."""
    result = project("--sdaeverify-tier", "ci", "--sdaeverify-seed", "7", "--collect-only")

    result.stdout.fnmatch_lines(["sdaeverify: claimed cells: 4, problems: 1, tier ci, seed 7;*"])


@pytest.mark.slow
def test_a_scheme_that_hangs_costs_its_own_test(project):
    """Where the policy has a time limit, a scheme that never ends is ended, and the others of its problem pass."""
    result = project(schemes=["hanging", "right"], further='timeout = 10.0\nmeasures = ["strong"]')

    result.assert_outcomes(passed=1, failed=1)
    result.stdout.re_match_lines([r"not measured: hanging on gbm, strong: .*", r"  reason: .*10 s.*"])


@pytest.mark.slow
def test_workers_say_the_same(pytester, project):
    """Spread over worker processes, cells of one problem come out as in one process."""
    schemes = ["right", "wrong"]
    project("--junitxml=one.xml", schemes=schemes)
    pytester.runpytest_subprocess("--sdaeverify", "-n2", "--junitxml=two.xml", "-p", "no:hypothesispytest")

    assert statuses(pytester, "two.xml") == statuses(pytester, "one.xml")


def test_without_the_option_there_is_nothing(pytester):
    """The plugin that every run of pytest loads neither adds tests nor imports anything."""
    heavy = {"numpy", "sdaeverify.registry.load", "sdaeverify.testing"}
    pytester.makepyfile(f"import sys\ndef test_it(): assert not {heavy} & set(sys.modules)")

    result = pytester.runpytest_subprocess("-p", "no:hypothesispytest")

    result.assert_outcomes(passed=1)
