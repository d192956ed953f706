"""``pytest --sdaeverify``: the lock file as a test."""

import pytest

from sdaeverify.gate.lock import Key, lock_text
from sdaeverify.study import Study

RIGHT, WRONG = (Key(name, "gbm", "strong", "x") for name in ("right", "wrong"))
ENDS = {key._replace(quantity="x@T"): "order >= 0.5" for key in (RIGHT, WRONG)}
LOCKED = {RIGHT: "order >= 0.5", WRONG: "order >= 0.9", **ENDS}
ITEM = "sdaeverify::lock file"


@pytest.fixture
def locked(pytester, project):
    """Write a lock file and return a function that runs pytest beside it."""

    def run(*arguments, claims=LOCKED, tier="smoke", schemes=("right", "wrong"), further=""):
        (pytester.path / "sdaeverify.lock").write_text(lock_text({tier: claims}))
        return project("-rs", *arguments, schemes=schemes, further=further)

    return run


def test_what_is_locked_is_there(locked):
    """The item is the last one, and passes where all claims are found, whether they hold or not."""
    result = locked("-v")

    result.assert_outcomes(passed=2, failed=1)
    assert [line for line in result.outlines if "::" in line][-1].startswith(f"{ITEM} PASSED")


def test_it_stays_the_last(pytester, locked):
    """Wherever others sort it to, it comes after the claims, and after the tests of files."""
    pytester.makepyfile(test_other="def test_it(): pass")
    pytester.makeconftest("def pytest_collection_modifyitems(items): items.reverse()")
    result = locked("-v")

    result.assert_outcomes(passed=3, failed=1)
    assert [line for line in result.outlines if "::" in line][-1].startswith(f"{ITEM} PASSED")


def test_what_is_locked_is_gone(locked):
    """A claim that is gone, or weaker, fails it, in the words of the gate."""
    gone = {RIGHT._replace(problem="ou"): "order >= 0.5", RIGHT: "order >= 0.7"}
    result = locked(claims={**LOCKED, **gone}, schemes=["right"])

    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "lock file: claim weakened: right on gbm, strong x: was order >= 0.7, is order >= 0.5",
            "lock file: no longer tested: right on ou, strong x: order >= 0.5",
            "lock file: no longer tested: wrong on gbm, strong x: order >= 0.9",
        ]
    )
    assert "Traceback" not in result.stdout.str()


def test_nothing_is_run_twice(locked, monkeypatch):
    """The item looks at the results that the claims have got."""
    run, studies = Study.run, []
    monkeypatch.setattr(Study, "run", lambda study, *given: studies.append(study) or run(study, *given))

    locked().assert_outcomes(passed=2, failed=1)

    assert len(studies) == 1


@pytest.mark.parametrize(
    ("arguments", "outcomes"),
    [
        (["-k", "right or lock"], {"passed": 1, "skipped": 1, "deselected": 1}),
        (["-k", "lock"], {"skipped": 1, "deselected": 2}),
        (["-k", "right"], {"passed": 1, "deselected": 2}),
        (["-m", "not sdaeverify"], {"deselected": 3}),
    ],
)
def test_a_part_of_the_claims(locked, arguments, outcomes):
    """Where claims that are locked are left out, nobody can tell, and it is skipped; it can be left out as well."""
    result = locked(*arguments)

    result.assert_outcomes(**outcomes)
    assert ("locked cells were not run here" in result.stdout.str()) == ("skipped" in outcomes)


def test_a_part_that_is_not_locked(locked):
    """Claims that are not in the file may be left out."""
    claims = {key: text for key, text in LOCKED.items() if key.scheme == "right"}

    locked("-k", "right or lock", claims=claims).assert_outcomes(passed=2, deselected=1)


@pytest.mark.parametrize("claims", [LOCKED, {}])
def test_another_tier(locked, claims):
    """There is no item where the file locks nothing for the tier."""
    locked(tier="ci", claims=claims, schemes=["right"]).assert_outcomes(passed=1)


@pytest.mark.parametrize(
    ("text", "further", "words"),
    [("[]", "", "is no lock file of version 1"), (None, 'lock = "my.lock"', "there is no lock file *my.lock")],
)
def test_a_file_that_cannot_be_used(pytester, project, text, further, words):
    """A lock file that is damaged, or named and not there, is wrong usage, as it is for the gate."""
    if text is not None:
        (pytester.path / "sdaeverify.lock").write_text(text)
    result = project(further=further)

    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: --sdaeverify: *{words}*"])


def test_a_cell_without_a_result_of_its_own(locked):
    """A cell that cannot be measured fails by its own test, and is not missed as well."""
    raising = {key._replace(scheme="raising"): text for key, text in LOCKED.items()}

    locked(claims=raising, schemes=["raising"]).assert_outcomes(passed=1, failed=1)


SPREAD = "SKIPPED*the tests are spread over 2 processes*"


def test_a_process_of_several(pytester, locked):
    """One of two processes that pytest-xdist has started has not the results of all: it is skipped and says why."""
    pytester.makeconftest(
        "def pytest_collection_finish(session): session.config.workerinput = {'workercount': 2, 'workerid': 'gw0'}"
    )
    result = locked()

    result.assert_outcomes(passed=1, failed=1, skipped=1)
    result.stdout.fnmatch_lines([SPREAD])


@pytest.mark.slow
def test_tests_spread_over_processes(pytester, locked):
    """So it is with the processes of pytest-xdist itself, wherever it runs."""
    pytest.importorskip("xdist")
    locked("--collect-only")
    result = pytester.runpytest_subprocess("--sdaeverify", "-rs", "-n2", "-p", "no:hypothesispytest")

    result.assert_outcomes(passed=1, failed=1, skipped=1)
    result.stdout.fnmatch_lines([SPREAD])
