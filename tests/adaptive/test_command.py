"""The command `adaptive`: its table, its objects for programs and its exit codes."""

import json
from pathlib import Path

import pytest

from facade import ExitCode, execute

pytestmark = pytest.mark.long

PLUGIN = """
from sdaeverify import Claim, hookimpl
from sdaeverify_adaptive.solvers.embedded import HeunPI
from sdaeverify_adaptive import Solved

class Mine(HeunPI):
    name = "mine"
    claims = (Claim(measure="tolerance", value=0.5, source="mine"),)

    def solve(self, problem, path, tolerance):
        {body}

@hookimpl
def sdaeverify_adaptive():
    return [Mine()]
"""
SMALL = ["-p", "ou", "--paths", "100", "--tolerances", "0.03,0.01,0.003"]


@pytest.fixture
def run(capsys):
    def words(*given):
        code = execute(["adaptive", *given])
        return ExitCode(code), capsys.readouterr()

    return words


@pytest.fixture
def plugin(tmp_path):
    def write(body):
        file = tmp_path / "mine.py"
        file.write_text(PLUGIN.format(body=body))
        return ["--plugin", str(file), "mine", *SMALL]

    return write


def test_a_table_tells_what_was_found_of_each_claim(run, monkeypatch):
    """A row for each claim and check below the pair, with no word broken; the counts, and what the code means."""
    monkeypatch.setenv("COLUMNS", "80")
    code, said = run("heun-pi", *SMALL)

    assert code is ExitCode.OK
    assert said.out.splitlines()[0] == "heun-pi on ou"
    for word in ("tolerance of x", "tolerance-steps of x", "own steps", "keeps its path", "exit code 0"):
        assert word in said.out


def test_programs_get_objects_with_the_work(run):
    """Each row is an object, with the error and the steps of every tolerance."""
    code, said = run("heun-pi", "--json", *SMALL)
    rows = json.loads(said.out)

    assert code is ExitCode.OK
    assert {row["measure"] for row in rows} >= {"tolerance", "own steps"}
    assert [each["tolerance"] for each in rows[0]["work"]] == [0.03, 0.01, 0.003]
    assert rows[0]["work"][0]["rms"] > rows[0]["work"][2]["rms"] > 0.0


def test_the_solver_of_the_how_to_keeps_its_claim(run):
    """The plugin file that the documentation shows is run as it is shown there."""
    code, said = run("--plugin", str(Path(__file__).parent / "halving.py"), "halving", *SMALL)

    assert code is ExitCode.OK
    assert "keeps its path" in said.out


def test_a_check_that_fails_is_a_refutation(run):
    """A solver whose paths share their steps ends the program with the code of a refuted claim."""
    code, said = run("planted-batch-norm", "-p", "gbm[a=0.1,b=0.8]", *SMALL[2:])

    assert code is ExitCode.REFUTED
    assert "own steps: refuted: row 0 has" in said.out


def test_what_a_solver_raises_is_an_error_of_its_cell(run, plugin):
    """A solver of a plugin file that raises is not measured, and its line is told."""
    code, said = run(*plugin("raise ValueError('no steps left')"))

    assert code is ExitCode.NOT_MEASURED
    assert "ValueError: no steps left" in said.out


def test_what_is_not_finite_diverges(run, plugin):
    """A solver that returns NaN is not measured."""
    code, said = run(*plugin("return Solved(float('nan') * path.at(0).W, 20, 0, 1)"))

    assert code is ExitCode.NOT_MEASURED
    assert "not finite" in said.out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["heun-pie"], "did you mean heun-pi?"),
        (["heun-pi", "--tolerances", "1,a"], "numbers separated by commas"),
        (["heun-pi", "--paths", "30"], "a multiple of 20"),
        (["heun-pi", "-p", "nowhere"], "unknown problem"),
    ],
)
def test_wrong_words_are_one_line(run, words, told):
    """Whatever is wrong with the command line is said in one line, with the code for it."""
    code, said = run(*words)

    assert code is ExitCode.USAGE
    assert told in said.err
    assert len(said.err.splitlines()) == 1


def test_where_nothing_is_claimed_nothing_is_measured(run):
    """A solver that claims nothing of a problem is named, and the code says that nothing was there."""
    code, said = run("heun-pi", "-p", "shear")

    assert code is ExitCode.NOTHING
    assert "heun-pi on shear: it has no claims on this problem" in said.out
