"""``compare``: two runs of matrix, the second with a scheme whose errors have changed."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from evidence import change_lanes, damage_lanes, lanes_in

SCHEME = '''
from typing import ClassVar

from sdaeverify import SDE, Claim, Scheme, Step, hookimpl


class Mine(Scheme):
    """Euler-Maruyama with a multiple of Milstein's correction for one Brownian motion."""

    name: ClassVar[str] = "mine"
    form: ClassVar[type] = SDE
    noise_dim: ClassVar[int] = 1
    claims: ClassVar = (Claim(measure="strong", value=0.5, source="test"),)

    def step(self, problem, state, t, h, noise):
        B = problem.diffusion(t, state)
        euler = state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW)
        if problem.noise_dim > 1:
            return Step(euler)
        correction = problem.derivative_of_diffusion(t, state, B[:, 0])[:, 0] * (noise.dW**2 - h)
        return Step(euler + {share} * 0.5 * correction)


@hookimpl
def sdaeverify_schemes():
    return [Mine()]
'''
# Of Milstein's correction: none, and the wrong sign, which leaves the order and doubles the error.
EULER, DOUBLED = 0.0, -1.0


@pytest.fixture
def measured(call_once):
    """Return a function that runs matrix with a version of the scheme."""

    def run(folder, share=EULER, problems="gbm", measures="strong", **changes):
        Path(f"{folder}.py").write_text(SCHEME.replace("{share}", str(share)))
        options = {"paths": 100, "levels": "8..32", "max_looks": 1, "jobs": 1, "progress": "none", **changes}
        words = [word for key, value in options.items() for word in ("--" + key.replace("_", "-"), str(value))]
        chosen = ("-s", "mine", "-p", problems, "-m", measures, "--plugin", f"{folder}.py")
        return call_once(folder, "matrix", *chosen, *words, also=share)

    return run


@pytest.fixture
def compared(call):
    """Return a function that compares two folders and returns exit code and JSON."""

    def run(*arguments):
        outcome = call("compare", *arguments, "--plugin", "old.py", "--json")
        answer = json.loads(outcome.out)
        return outcome.code, {**answer, **answer["pairs"][0]}

    return run


def by_quantity(answer):
    return {row["quantity"]: row for row in answer["quantities"]}


@pytest.mark.long
def test_order_kept_and_error_doubled(measured, compared):
    """With 256 paths the claimed order is verified all the same, and the comparison tells the error has doubled."""
    budget = {"paths": 256, "levels": "8..256"}
    assert (measured("old", **budget).code, measured("new", DOUBLED, **budget).code) == (0, 0)
    assert set(pd.read_csv("new/verdicts.csv").verdict) == {"verified"}
    code, answer = compared("old", "new")

    assert code == answer["exit_code"] == 1
    row = by_quantity(answer)["x@T"]
    assert row["verdict"] == "worse"
    assert 1.9 < row["ci_low"] < row["factor"] < row["ci_high"] < 2.1
    assert (row["paths"], row["levels"]) == (256, 4)


@pytest.mark.long
def test_guards_are_compared_where_they_were_enough(measured, compared):
    """Errors of paths on the levels of guards are compared on these, unless the other run has all levels."""
    few, every = {"paths": 256, "first-levels": 4, "levels": "8..256"}, {"paths": 256, "levels": "8..256"}
    for folder, budget in {"old": few, "new": few, "whole": every}.items():
        measured(folder, EULER if folder == "old" else DOUBLED, **budget)

    _, answer = compared("old", "new")
    _, other = compared("old", "whole")

    row = by_quantity(answer)["x@T"]
    assert (row["verdict"], row["paths"]) == ("worse", 256)
    assert other["quantities"] == []
    assert "not in both runs on as many levels" in str(other)


@pytest.mark.long
def test_a_plugin_that_is_needed_again_is_named_with_its_option(measured, call):
    """A run says which plugin files it was made with; without them its schemes are unknown."""
    measured("old"), measured("new", DOUBLED)
    outcome = call("compare", "old", "new")

    file = Path("new.py").resolve()
    assert f"not registered here: mine; new was made with plugin files: add --plugin {file}\n" in outcome.err
    assert call("compare", "old", "new", "--plugin", str(file)).err == ""


@pytest.mark.long
def test_a_leading_error_that_changes_is_told(measured, compared):
    """Without sampling the constant of E x^2 is another one, whatever paths resolve; that of E x is the same."""
    measured("old", measures="weak"), measured("new", DOUBLED, measures="weak")
    _, answer = compared("old", "new")

    assert [row["quantity"] for row in answer["constants"]] == ["x^2"]
    assert answer["constants"][0]["before"] == "-2.63 h"
    assert answer["constants"][0]["after"] != "-2.63 h"
    assert compared("old", "old")[1]["constants"] == []


@pytest.mark.long
def test_improvement_is_shown_and_no_failure(measured, call):
    """The other way round the errors are better, which is in the table, and the command succeeds."""
    measured("old"), measured("new", DOUBLED)
    outcome = call("compare", "new", "old", "--plugin", "new.py")

    assert outcome.code == 0
    assert "mine on gbm, strong x@T: better, error x 0.5" in outcome.out
    assert outcome.out.count(": better, ") == 2
    assert "2 quantities compared: none worse, 2 better, none the same, none" in " ".join(outcome.out.split())
    assert all(len(line) <= 80 for line in outcome.out.splitlines())


@pytest.mark.long
def test_the_same_scheme_has_the_factor_one(measured, compared, call):
    """Runs of the same scheme agree to the last bit, and the table has nothing to show."""
    measured("old"), measured("new")
    code, answer = compared("old", "new")

    assert code == 0
    assert {row["verdict"] for row in answer["quantities"]} == {"same"}
    assert {row[key] for row in answer["quantities"] for key in ("factor", "ci_low", "ci_high")} == {1.0}
    assert "x@T" not in call("compare", "old", "new", "--plugin", "old.py").out
    assert "x@T" in call("compare", "old", "new", "--plugin", "old.py", "--all").out


@pytest.mark.long
@pytest.mark.parametrize(
    ("further", "words"),
    [
        ({"seed": 7}, "seed 20170601 in old and 7 in new"),
        ({"levels": "16..64"}, "coarsest 8 in old and 16 in new"),
        ({"block": 512}, "block 4096 in old and 512 in new"),
    ],
)
def test_errors_are_compared_on_common_noise_alone(measured, call, further, words):
    """Verdicts are compared all the same, and the setting that differs is named."""
    measured("old"), measured("new", EULER, **further)
    outcome = call("compare", "old", "new")

    assert outcome.code == 0
    told = " ".join(outcome.out.split())
    assert f"errors are compared on common noise, with the same settings: {words}" in told
    assert "0 quantities compared" in told


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("old", "nowhere"), "nowhere holds no run"),
        (("old", "empty"), "empty holds no run: cannot read verdicts.csv"),
        (("old", "old", "--factor", "1"), "the factor must be above 1, got 1.0"),
        (("old", "old", "--alpha", "0"), "alpha must be above 0"),
        (("old",), "compare needs two runs or more"),
    ],
)
def test_what_a_user_gets_wrong(measured, call, arguments, words):
    """It is one line and exit code 2."""
    measured("old")
    Path("empty").mkdir()
    shutil.copy("old/run.json", "empty")
    outcome = call("compare", *arguments)

    assert outcome.code == 2
    assert words in outcome.err.lower().replace("'", "") or words in outcome.err
    assert len(outcome.err.splitlines()) == 1


def emptied(data):
    return b""


def test_damaged_evidence(measured, call):
    """Where no evidence of the run can be read, that is what is told."""
    measured("old"), measured("new", DOUBLED)
    every = len(lanes_in(Path("new")))
    damage_lanes(Path("new/evidence/gbm.sqlite"), emptied)
    outcome = call("compare", "old", "new", "--plugin", "old.py")

    assert (outcome.code, outcome.out) == (2, "")
    told = f"{every} pieces of evidence in new are damaged; run matrix or gate with --out new"
    assert outcome.err == f"sdaeverify: error: {told}\n"


@pytest.mark.long
def test_evidence_that_is_damaged_in_part(measured, call):
    """What is left is compared, and a warning tells how much is not."""
    measured("old", problems="gbm,ou"), measured("new", problems="gbm,ou")
    damaged = sum(file.name == "ou.sqlite" for file, _, _ in lanes_in(Path("new")))
    damage_lanes(Path("new/evidence/ou.sqlite"), emptied)
    outcome = call("compare", "old", "new", "--plugin", "old.py")

    assert outcome.code == 0
    assert outcome.err == f"sdaeverify: warning: {damaged} pieces of evidence in new are damaged and left out\n"
    assert "not compared: mine on ou: only old has paths of this cell; new has none" in outcome.out


@pytest.mark.long
def test_a_scheme_that_was_refuted_before_any_path(measured, call, tmp_path):
    """Nothing was simulated, so that no errors are compared: its claims are newly refuted, and back again."""
    measured("old")
    plugin = tmp_path / "wrong.py"
    wrong = SCHEME.replace("h * problem.drift(t, state)", "2 * h * problem.drift(t, state)")
    plugin.write_text(wrong.replace("{share}", str(EULER)))
    run = ("-s", "mine", "-p", "gbm", "-m", "strong", "--plugin", str(plugin), "--out", "new")
    budget = ("--paths", "100", "--levels", "8..32", "--max-looks", "1", "--jobs", "1", "--progress", "none")
    assert call("matrix", *run, *budget).code == 1
    refuted, mended = (call("compare", *runs) for runs in (("old", "new"), ("new", "old")))

    assert (refuted.code, mended.code) == (1, 0)
    assert refuted.err == mended.err == ""
    assert (
        "0 errors grown beyond the factor, 9 claims newly refuted\nexit code 1: a claim is refuted, or a check fails"
        in refuted.out
    )
    assert "mine on gbm, strong x: inconclusive -> refuted" in refuted.out
    assert "mine on gbm, strong x: refuted -> inconclusive" in mended.out


def with_ingredients(**changes):
    return lambda lane: lane._replace(ingredients={**lane.ingredients, **changes})


def of_another_shape(lane):
    odd = {name: array[:3] for name, array in lane.measures["strong"].sampled.sums.items()}
    record = lane.measures["strong"]
    return lane._replace(measures={"strong": record._replace(sampled=replace(record.sampled, sums=odd))})


def with_another_problem(lane):
    return lane._replace(behaviour=lane.behaviour._replace(problem="other"))


def renamed_measure(lane):
    return lane._replace(measures={"sideways": lane.measures["strong"]})


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (with_another_problem, "the problem has changed"),
        (with_ingredients(**{"paths of the block": "9 drawn, 9 used"}), "first block of paths is not in both runs"),
        (of_another_shape, "its evidence cannot be read: "),
        (renamed_measure, "only in old"),
    ],
)
def test_evidence_that_cannot_be_compared(measured, compared, change, reason):
    """Each cell that is left out is listed with its reason, and a comparison of nothing is no success."""
    measured("old")
    shutil.copytree("old", "new")
    change_lanes(Path("new"), change)
    code, answer = compared("old", "new")

    assert code == 5
    assert answer["quantities"] == []
    assert any(row["reason"].startswith(reason) or reason in row["reason"] for row in answer["omitted"])


@pytest.mark.long
def test_a_scheme_that_is_not_registered_here(measured, call):
    """Without its plugin the components of a scheme have no names: verdicts alone are compared, and it says why."""
    measured("old"), measured("new")
    outcome = call("compare", "old", "new")
    outcome = outcome._replace(out=" ".join(outcome.out.split()))

    assert outcome.code == 5
    assert "errors of no quantity could be compared; 9 verdicts of both runs are the same" in outcome.err
    assert (
        "not compared: mine on gbm: it cannot be built here: mine is not registered here; load its file"
        in outcome.out
    )


@pytest.mark.long
def test_cells_of_one_run_only(measured, call):
    """They are listed, and the others are compared."""
    measured("old"), measured("new", EULER, "gbm,ou")
    outcome = call("compare", "old", "new", "--plugin", "old.py")

    assert outcome.code == 0
    assert "not compared: mine on ou: only new has paths of this cell; old has none" in outcome.out
    assert " quantities compared: none worse, none better" in outcome.out


def test_names_from_elsewhere_are_shown_in_letters(measured, call):
    """A run from elsewhere may name anything: what is said of it steers neither a terminal nor a log."""
    measured("old")
    shutil.copytree("old", "new")
    nasty = "\x1b[2J\n::error::=1+1"
    change_lanes(Path("new"), with_ingredients(scheme=nasty))
    about = json.loads(Path("new/run.json").read_text(encoding="utf-8"))
    about["selection"]["schemes"] = [nasty]
    Path("new/run.json").write_text(json.dumps(about), encoding="utf-8")
    outcome, answer = call("compare", "old", "new"), call("compare", "old", "new", "--json")

    assert outcome.code == answer.code == 5
    assert "\\x1b[2J\\n::error::" in outcome.out
    assert all(line.isprintable() and not line.startswith("::") for line in outcome.out.split("\n"))
    assert answer.out.isascii()
    assert "\x1b" not in answer.out


@pytest.mark.long
def test_three_runs_in_a_row(measured, call):
    """Each is compared with the one before; a claim that is newly refuted is told, and fails."""
    budget = {"paths": 256, "levels": "8..256"}
    for folder in ("first", "second", "third"):
        measured(folder, **budget)
    table = pd.read_csv("third/verdicts.csv", dtype=str, keep_default_na=False)
    table.assign(verdict="refuted").to_csv("third/verdicts.csv", index=False)
    outcome = call("compare", "first", "second", "third", "--plugin", "first.py")

    assert outcome.code == 1
    assert "first -> second\n0 of 9 verdicts changed" in outcome.out
    assert "mine on gbm, strong x@T: verified -> refuted" in outcome.out
