"""The command `sealed`: its table, its objects for programs, its exit codes, and the solver of the how-to."""

import json
from pathlib import Path

import pytest

from facade import ExitCode, execute
from sdaeverify_sealed.run import select_solvers
from sealed.solving import registry

pytestmark = pytest.mark.long
HERE = Path(__file__).parent
SMALL = ["-p", "ou", "--paths", "8192", "--looks", "1"]


@pytest.fixture
def run(capsys):
    def words(*given):
        code = execute(["sealed", *given])
        return ExitCode(code), capsys.readouterr()

    return words


def test_a_table_tells_what_was_found_of_each_claim(run):
    """A row for each claim and check, the counts, and what the code means."""
    code, said = run("own-euler", *SMALL)

    assert code is ExitCode.OK
    for word in ("weak of x", "invariant of x^2", "standard errors", "own seeds", "same seed", "exit code 0"):
        assert word in said.out


def test_programs_get_objects(run):
    """Each row is an object."""
    code, said = run("own-euler", "--json", *SMALL)
    found = json.loads(said.out)

    assert code is ExitCode.OK
    assert {row["measure"] for row in found} >= {"weak", "invariant", "own seeds"}
    assert {row["claim"] for row in found} == {"order >= 1.0", None}


def test_a_check_that_fails_is_a_refutation(run):
    """A solver that ignores its seed ends the program with the code of a refuted claim."""
    code, said = run("planted-seedless", *SMALL)

    assert code is ExitCode.REFUTED
    assert "give the same numbers" in said.out


def test_the_solver_of_the_how_to_is_judged(run):
    """The plugin file that the documentation shows is run as it is shown there, on two workers."""
    code, said = run("--plugin", str(HERE / "exact_ou.py"), "exact-ou", *SMALL, "-j", "2")

    assert code is ExitCode.OK
    assert "verified" in said.out
    assert "exact-ou" in said.out


def test_nothing_depends_on_which_libraries_are_installed():
    """Without a name, solvers of other libraries and planted ones are left out."""
    assert {made.name for made in select_solvers(registry(), [])} == {"own-baoab", "own-euler", "own-platen"}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["own-eulr"], "did you mean own-euler?"),
        (["own-euler", "--steps", "4,a,8"], "whole numbers separated by commas"),
        (["own-euler", "--steps", "4,8"], "at least three increasing numbers of steps"),
        (["own-euler", "--paths", "100"], "at least 3200 for 3 looks"),
        (["own-euler", "-p", "nowhere"], "unknown problem"),
    ],
)
def test_wrong_words_are_one_line(run, words, told):
    """Whatever is wrong with the command line is said in one line, with the code for it."""
    code, said = run(*words)

    assert code is ExitCode.USAGE
    assert told in said.err
    assert len(said.err.splitlines()) == 1


def test_where_nothing_is_claimed_nothing_is_measured(run):
    """A solver of another form is named, and the code says that nothing was there."""
    code, said = run("own-baoab", *SMALL)

    assert code is ExitCode.NOTHING
    assert "own-baoab on ou: own-baoab does not solve problems of this form" in said.out
