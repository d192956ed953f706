"""Results of `orders`, `adaptive`, `sealed` and `hunt` that ``--out`` saves: a run like any other."""

import json
from pathlib import Path

import pytest

from facade import ExitCode
from sdaeverify import load

pytestmark = pytest.mark.long

# The command, the scheme, the arguments, a measure, and part of a line of `show`.
COMMANDS = {
    "orders": ("milstein", ["--class", "scalar,ode"], "weak", "weak order 1 verified for smooth equations"),
    "adaptive": ("heun-pi", ["-p", "ou", "--paths", "100", "--tolerances", "0.03,0.01,0.003"], "tolerance", "T3"),
    "hunt": ("milstein", ["-m", "strong", "--when", "scalar-noise", "--examples", "3"], "strong", "strong claim"),
    "sealed": ("own-euler", ["-p", "ou", "--paths", "8192", "--looks", "1"], "weak", "weak x"),
}


@pytest.fixture(params=COMMANDS)
def saved(request, call):
    """Run a command with ``--out``; return its name and what it prints."""
    scheme, words, *_ = COMMANDS[request.param]
    if request.param == "hunt":
        pytest.importorskip("hypothesis", reason="needs the extra hunt")
    progress = [] if request.param == "orders" else ["--progress", "none", "-j", "1"]
    return request.param, call(request.param, scheme, *words, *progress, "--out", "kept").out


def test_show_opens_what_was_kept(saved, call):
    """The last lines name the page and the command, which prints findings, reasons and how to repeat them."""
    command, printed = saved
    scheme, _, _, found = COMMANDS[command]
    problem = {"orders": "every-equation*", "hunt": "random-problem*"}.get(command, "ou")

    assert "sdaeverify show kept" in printed
    assert Path("kept/report.html").is_file()
    assert found in call("show", "kept", scheme).out
    assert scheme in call("show", "kept").out
    told = call("show", "kept", scheme, problem).out
    assert f"python -m sdaeverify {command} {scheme}" in " ".join(told.split())


def test_a_kept_result_is_loaded(saved):
    """`load` has its verdicts in the table of all runs, with claims, levels and the command of each row."""
    command, _ = saved
    scheme, _, measure, _ = COMMANDS[command]
    result = load("kept")
    rows = result.verdicts[result.verdicts.measure == measure]
    problem = rows.problem.iloc[0]

    assert set(rows.scheme) == {scheme}
    assert set(rows.verdict) <= {"verified", "inconclusive", "out_of_scope"}
    assert result.command(scheme, problem, measure).startswith(f"python -m sdaeverify {command} {scheme}")
    if command in {"adaptive", "sealed"}:
        assert set(result.levels.problem) == {"ou"}


def test_claims_know_what_was_kept(saved, call):
    """`claims` of the folder tells what the run says of the claims of the scheme."""
    scheme, _, measure, _ = COMMANDS[saved[0]]
    assert f"{scheme}, {measure} " in call("claims", scheme, "kept").out


def test_a_folder_of_another_program_is_left_alone(call):
    """Nothing is measured for a folder whose run.json is not of this program, and the file stays."""
    Path("kept").mkdir()
    Path("kept/run.json").write_text(json.dumps({"name": "another"}))
    for command, (scheme, words, *_) in COMMANDS.items():
        done = call(command, scheme, *words, "--out", "kept")
        assert done.code is ExitCode.USAGE, command
        assert "belongs to no run of this program" in done.err
    assert json.loads(Path("kept/run.json").read_text()) == {"name": "another"}


def test_modified_equations_are_not_kept(call):
    """They are no verdicts: one line says so."""
    done = call("orders", "milstein", "--modified", "--out", "kept")
    assert done.code is ExitCode.USAGE
    assert "contradictory options: --out saves verdicts, and --modified gives none" in done.err
    assert not Path("kept").exists()
