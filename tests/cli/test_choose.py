"""``choose``: a table of schemes by their work, JSON for programs, and a line for each mistake."""

import json

import pytest

from sdaeverify import SDE, UsageError, verify

FEW = ("-s", "milstein,euler-maruyama,displaced-euler", "--paths", "512", "--levels", "8..64")


@pytest.fixture
def eighty(monkeypatch):
    """Make the terminal 80 columns wide."""
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.usefixtures("eighty")
def test_a_table_of_eighty_columns(call):
    """The least work first, with order, noise, steps and verdict; then who is verified, and what else there is."""
    outcome = call("choose", "gbm", *FEW, "--accuracy", "0.03")

    lines = outcome.out.splitlines()
    assert outcome.code == 0
    assert all(len(line.rstrip()) <= 80 for line in lines)
    assert lines[0].startswith("Which scheme for gbm: work for an error of strong x of 0.03")
    assert lines[3].rstrip().endswith("x 1.0")
    assert "left out, with a refuted claim or as a negative control: displaced-euler" in lines
    assert any(line.startswith("errors: to the exact solution on each path") for line in lines)
    assert {"verified on gbm: milstein, euler-maruyama", "verified on gbm: euler-maruyama, milstein"} & {*lines}


def test_json_is_one_object(call):
    """With problem, measure, quantity, accuracy and a list of schemes, unknown numbers being null."""
    outcome = call("choose", "gbm", *FEW, "--accuracy", "0.03", "--json")

    told = json.loads(outcome.out)
    assert (told["problem"], told["measure"], told["quantity"], told["accuracy"]) == ("gbm", "strong", "x", 0.03)
    known = told["schemes"]
    assert {one["scheme"] for one in known} == {"milstein", "euler-maruyama"}
    assert known[0]["seconds"] <= known[1]["seconds"]
    assert told["left_out"] == ["displaced-euler"]


def test_a_finished_run_is_asked(call, tmp_path):
    """Nothing is computed where a folder is given; the table is that of the run."""
    verify("milstein", "gbm", "strong", paths=512).save(tmp_path / "run")
    outcome = call("choose", "gbm", "--run", "run")

    assert outcome.code == 0
    assert "milstein" in outcome.out


@pytest.mark.long
@pytest.mark.usefixtures("eighty")
def test_names_are_not_broken(call):
    """A table with a name that does not fit is wider than the terminal, and each name is in one piece."""
    name = "semi-implicit-projection-euler[noise_projector=new]"
    outcome = call("choose", "sphere-langevin", "-s", name, "--paths", "256", "--levels", "8..32", "-m", "weak")

    assert any(line.split()[1:2] == [name] for line in outcome.out.splitlines())


def test_stationary_means(call):
    """Errors of stationary means are those to the exact ones, with steps a unit of time."""
    outcome = call("choose", "ou", "-m", "invariant", "-s", "euler-maruyama,heun-additive", "--paths", "256")

    assert outcome.code == 0
    assert "errors: relative to the exact stationary mean" in outcome.out
    assert "steps a unit of time" in outcome.out


def test_no_scheme_reaches_it(call):
    """What no order can tell is exit code 5, in one line."""
    outcome = call(
        "choose", "gbm", "-s", "balanced-euler", "--paths", "256", "--levels", "8..32", "--accuracy", "1e-9"
    )

    assert outcome.code == 5
    assert "no scheme is known to reach 1e-09" in outcome.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["gmb"], "unknown problem 'gmb'; did you mean gbm"),
        (["gbm", "--accuracy", "0"], "--accuracy expects the error to reach, a positive number, got 0"),
        (["gbm", "--accuracy", "nan"], "--accuracy expects the error to reach"),
        (["gbm", "-m", "drift"], "'drift' is not one of 'strong', 'weak', 'invariant'"),
        (["gbm", "--quantity", "y", *FEW], "no strong error of y is known on gbm; there are x, x@T"),
        (["gbm", "--run", "nowhere"], "nowhere holds no run"),
        (["gbm,ou"], "choose takes one problem, got 'gbm,ou'"),
        (["*"], "choose takes one problem, got '*'"),
        (["gbm", "--levels", "8..9"], "levels expects"),
        (["gbm", "-s", "baoab"], "no strong error is known on gbm"),
        ([], "missing argument"),
    ],
    ids=repr,
)
def test_mistakes(call, words, message):
    """One line behind the cells that were measured until then, exit code 2."""
    outcome = call("choose", *words)

    line, *others = (told for told in outcome.err.splitlines() if not told.endswith(" s"))
    assert not others
    assert message in line
    assert outcome.code == 2


def test_progress_has_a_total_while_schemes_are_compared(call):
    """The comparison, which may take longer than the run before it, says on how many of the paths it is done."""
    lines = call("choose", "gbm", *FEW, "--accuracy", "0.03", "--progress", "plain").err.splitlines()
    silent = call("choose", "gbm", *FEW, "--accuracy", "0.03", "--progress", "none").err

    assert lines[-2:] == ["gbm  compared on 256 of 512 paths", "gbm  compared on 512 of 512 paths"]
    assert silent == ""


def test_a_problem_without_observables_has_no_weak_errors():
    """More paths would not show any: the message says what to give it."""

    def growth() -> SDE:
        """Return dx = x dt + x dW, with nothing to observe."""
        return SDE(
            drift=lambda t, x: x,
            diffusion=lambda t, x: x[:, None],
            start=[1.0],
            noise_dim=1,
            horizon=1.0,
            observables={},
            source="a test",
        )

    result = verify("euler-maruyama", growth, ["strong", "weak"], paths=256, levels="8..32")

    assert result.choose("growth", "strong").found
    with pytest.raises(UsageError, match="the problem has no observables"):
        result.choose("growth", "weak")
    with pytest.raises(UsageError, match="sdaeverify matrix -p growth -m invariant --dry-run says why"):
        result.choose("growth", "invariant")
