"""``claims``: a line for each claim of a scheme, with all that the folder of a run tells of it."""

import json
from pathlib import Path

import pytest

import sdaeverify

BUDGET = ("--paths", "400", "--levels", "8..64", "-j", "1", "--progress", "none", "--no-html")
ODD = "return Step(state + h * 0.5 * problem.drift(t, state) + problem.diffused(t, state, noise.dW))"


@pytest.fixture
def finished(call_once):
    """Return a finished run of two schemes on one problem."""
    return call_once("out", "matrix", "-s", "milstein,displaced-euler", "-p", "gbm", "-m", "strong,weak", *BUDGET)


def lines_of(outcome):
    """Return the lines of what was printed, continued lines joined."""
    return outcome.out.replace("\n    ", " ").splitlines()


def test_a_claim_has_one_line_with_problems_and_classes(finished, call):
    """Traits that a problem must have, findings on problems, for classes; a claim that nothing tests says so."""
    outcome = call("claims", "milstein", "out")
    *told, counts, code = lines_of(outcome)
    where = "milstein, strong order >= 1.0 where the problem has linear-growth"
    assert f"{where}: on problems 2 verified; for classes of equations 3 verified" in told
    assert "milstein, drift order >= 1.0: tested nowhere" in told
    assert len(told) == 6
    assert counts == "6 claims: 2 verified, 4 tested nowhere"
    assert code == "exit code 5: nothing was measured, or not all that is claimed or locked"
    assert outcome.code == 5


@pytest.mark.long
def test_a_refuted_claim_names_what_refutes_it(call, odd_scheme):
    """A scheme that halves the drift is refuted on the problem and for classes, and the exit code says so."""
    call("matrix", "--plugin", odd_scheme(ODD), "-s", "odd", "-p", "gbm", "--out", "out", *BUDGET)
    outcome = call("claims", "odd", "out")
    (line, *_) = lines_of(outcome)
    assert line.startswith("odd, strong order >= 1.0: on problems 1 refuted; for classes of equations 7 refuted; ")
    assert "refuted on gbm, the class ode, the class scalar and " in line
    assert outcome.code == 1


def test_json_is_a_list_of_claims_with_counts(finished, call):
    """Objects hold the same as the lines; with -m claims about one measure alone, none of which is untested."""
    outcome = call("claims", "*", "out", "-m", "weak", "--json")
    rows = json.loads(outcome.out)
    (own,) = (each for each in rows if each["scheme"] == "milstein" and each["when"] == ["linear-growth"])
    assert own["problems"] == {"verified": 3, "refuted": 0, "undecided": 0, "not measured": 0}
    assert own["worst"] == "verified"
    assert own["sources"]


def test_what_could_not_be_measured_is_told_of_each_claim(call, odd_scheme):
    """A step that raises leaves its claim without a measurement: exit code 3."""
    call(
        "matrix", "--plugin", odd_scheme("raise ValueError('no')"), "-s", "odd", "-p", "gbm", "--out", "out", *BUDGET
    )
    outcome = call("claims", "odd", "out")
    assert "odd, strong order >= 1.0: on problems 1 not measured" in lines_of(outcome)[0]
    assert outcome.code == 3


def test_hunts_of_a_gate_stand_beside_the_cells(finished, call):
    """A hunt says how many examples a claim is about, and whether one of them refutes it."""
    attack = {"scheme": "milstein", "measure": "strong", "form": "SDE", "claims": {"order >= 1.0": 7}, "refuted": ""}
    Path("out/gate.json").write_text(json.dumps({"attacks": [attack]}))
    assert lines_of(call("claims", "milstein", "out"))[0].endswith("; not refuted by a hunt, 7 examples of SDE")
    Path("out/gate.json").write_text(json.dumps({"attacks": [{**attack, "refuted": "order >= 1.0"}]}))
    outcome = call("claims", "milstein", "out")
    assert lines_of(outcome)[0].endswith("; refuted by a hunt, 7 examples of SDE")
    assert outcome.code == 1


def test_the_hunt_of_an_earlier_run_is_left_out(finished, call):
    """A run in the folder of a gate has another date than its report; the report of the same run counts."""
    attack = {"scheme": "milstein", "measure": "strong", "form": "SDE", "claims": {"order >= 1.0": 7}, "refuted": ""}
    date = json.loads(Path("out/run.json").read_text())["date"]
    for own, read in ((date, True), ("2020-01-01T00:00:00+00:00", False)):
        Path("out/gate.json").write_text(json.dumps({"attacks": [attack], "date": own}))
        outcome = call("claims", "milstein", "out")
        assert ("hunt" in lines_of(outcome)[0]) is read
        assert ("out/gate.json is about an earlier run in this folder" in outcome.err) is not read
    Path("out/gate.json").unlink()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("milsten", "out"), "no claim in out is of milsten; did you mean milstein?"),
        (("milstein", "out", "-m", "storng"), "no claim in out is of milstein, about storng; did you mean strong?"),
        (("milstein", "nowhere"), "nowhere holds no run: cannot read verdicts.csv"),
        (("out",), "expected SCHEME, got the folder of a run; sdaeverify claims '*' out shows it"),
    ],
)
def test_mistakes_cost_one_line(finished, call, words, told):
    """An unknown scheme, measure or folder is named, and the exit code is 2 or 3."""
    outcome = call("claims", *words)
    assert told in outcome.err
    assert outcome.code in {2, 3}
    assert outcome.err.count("\n") == 1


def test_a_damaged_folder_costs_one_line(finished, call):
    """Claims or hunts that are not as this program writes them are refused."""
    Path("out/gate.json").write_text('{"attacks": [3]}')
    outcome = call("claims", "milstein", "out")
    assert "out/gate.json is not as this program writes it" in outcome.err
    run = json.loads(Path("out/run.json").read_text())
    Path("out/gate.json").unlink()
    Path("out/run.json").write_text(json.dumps({**run, "claims": 3}))
    assert "does not describe a run in the format of this program" in call("claims", "milstein", "out").err


def test_a_result_has_the_same_table(finished):
    """In a program, a data frame with a row for each claim."""
    table = sdaeverify.load("out").claims.set_index(["scheme", "measure", "claim"])
    row = table.loc[("milstein", "strong", "order >= 1.0")]
    assert (row["problems.verified"], row["classes.verified"], row["worst"]) == (2, 3, "verified")


def test_a_shell_completes_schemes(call, monkeypatch):
    """The first word is the name of a scheme."""
    monkeypatch.setenv("_SDAEVERIFY_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "sdaeverify claims mils")
    monkeypatch.setenv("COMP_CWORD", "2")
    assert "plain,milstein" in call().out
