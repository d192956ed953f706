"""Examinations of plugins in a gate: outcomes, lock, page and commands; that of adaptive solvers first."""

import json
from pathlib import Path

import pytest

from facade import ExitCode, execute
from sdaeverify.gate.policy import Policy

pytestmark = pytest.mark.long

POLICY = """
[tool.sdaeverify]
schemes = ["euler-maruyama"]
problems = ["gbm", "ou"]
measures = ["strong"]
tier = "smoke"

[tool.sdaeverify.examinations.adaptive]
solvers = [{solvers}]
problems = ["ou"]
paths = 200
tolerances = [0.01, 0.003, 0.001]
"""
COUNTING = """
from sdaeverify import hookimpl
from sdaeverify.measuring import Finding, Measure, Reason, Verdict
from sdaeverify.studying import Advanced, Cell, CellResult, Examination, select_problems, select_schemes

class Letters(Measure):
    name = "letters"

class Work:
    total, notes, command = 1, ("letters are counted",), ("list", "{scheme}", "{problem}")

    def __init__(self, cell):
        self.cell = cell

    def run(self, executor=None, window=1):
        yield Advanced(1, 1, "gbm")

    @property
    def results(self):
        claim = self.cell.scheme.promises[0]
        found = Finding(quantity="name", verdict=Verdict.REFUTED, reason=Reason("14 letters"), claim=claim)
        return [CellResult(self.cell, (found,))]

class Counting(Examination):
    name = "counting"

    def begin(self, registry, asked, settings):
        (scheme,), (problem,) = select_schemes(registry, "euler-maruyama"), select_problems(registry, "gbm")
        return Work(Cell(scheme, problem, Letters()))

@hookimpl
def sdaeverify_examinations():
    return [Counting()]
"""


@pytest.fixture
def gate(tmp_path, monkeypatch, capsys):
    """Run a gate in a folder with a policy; return its exit code and what is said."""
    monkeypatch.chdir(tmp_path)

    def run(*words, policy="", solvers='"heun-pi"'):
        Path("pyproject.toml").write_text(policy or POLICY.format(solvers=solvers))
        code = execute(["gate", "-j", "1", "--progress", "none", *words])
        return ExitCode(code), capsys.readouterr()

    return run


def test_claims_of_a_solver_are_gated_locked_and_on_the_page(gate):
    """A right solver passes beside the schemes; its claims are in the lock, the tables and the page."""
    code, said = gate("--write-lock")
    outcomes = json.loads(Path("reports/gate/gate.json").read_text())["outcomes"]
    rows = {(row["measure"], row["quantity"]): row for row in outcomes if row["scheme"] == "heun-pi"}

    assert code is ExitCode.OK, said.out
    assert {measure for measure, _ in rows} == {"tolerance", "tolerance-steps", "tolerance-law"}
    assert rows["tolerance", "x"]["reproduce"] == (
        "python -m sdaeverify adaptive heun-pi -p ou --paths 200 --seed 20170601 --tolerances 0.01,0.003,0.001"
    )
    assert '"tolerance": {' in Path("sdaeverify.lock").read_text()
    assert "heun-pi" in Path("reports/gate/report.html").read_text()


def test_a_wrong_solver_is_red_and_a_locked_one_is_missed(gate):
    """A solver that fails a check is refuted by its name; a locked claim that nobody examines any more is missed."""
    code, said = gate("--write-lock", solvers='"planted-batch-norm"')

    assert code is ExitCode.REFUTED
    assert "own steps: row 0 has" in said.out

    code, said = gate(solvers="")

    assert code is ExitCode.NOTHING
    assert "no longer tested: planted-batch-norm on ou, tolerance x" in said.out


def test_a_part_of_a_gate_leaves_examinations_out(gate):
    """Where the command line selects schemes, the examinations are named as left out."""
    code, said = gate("-s", "euler-maruyama")

    assert code is ExitCode.OK
    assert "examinations of adaptive are left out where a part is selected" in said.out


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (
            ("examinations.adaptive", "examinations.adaptiv"),
            "no examination is named adaptiv; did you mean adaptive?",
        ),
        (('"heun-pi"', '"heun-pie"'), "did you mean heun-pi?"),
        (('"heun-pi"', "1"), "Expected `str`, got `int`"),
        (("paths =", "path ="), "unknown field `path`"),
        (("paths = 200", "paths = 201"), "a multiple of 20"),
        (('["ou"]', '["nowhere"]'), "nowhere"),
    ],
)
def test_a_wrong_table_is_told_with_its_file_before_anything_is_run(gate, wrong, told):
    """One line names the policy, the table and what is expected."""
    code, said = gate(policy=POLICY.format(solvers='"heun-pi"').replace(*wrong))

    assert code is ExitCode.USAGE
    assert said.err.startswith("sdaeverify: error: ")
    assert "pyproject.toml: [tool.sdaeverify.examinations]" in said.err
    assert told in said.err
    assert not Path("reports/gate/verdicts.csv").exists()


def test_a_plugin_examines_what_it_likes(gate):
    """An examination of a plugin file counts in the gate, with its command and its note."""
    Path("counting.py").write_text(COUNTING)
    policy = POLICY.partition("[tool.sdaeverify.examinations")[0] + "[tool.sdaeverify.examinations.counting]\n"
    code, said = gate("--plugin", "counting.py", policy=policy)

    assert code is ExitCode.REFUTED
    assert "14 letters" in said.out
    assert "python -m sdaeverify list euler-maruyama gbm --plugin" in said.out
    assert "note: letters are counted" in said.out


def test_cells_and_examinations_share_alpha():
    """The probability of a false alarm is that of all of a gate together."""
    alone, beside = Policy(alpha=0.01), Policy(alpha=0.01, examinations={"adaptive": {}})

    assert 1.0 - alone.settings.confidence == pytest.approx(0.01)
    assert 1.0 - beside.settings.confidence == pytest.approx(0.005)
