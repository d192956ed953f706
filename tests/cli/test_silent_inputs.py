"""Inputs that once passed silently: each gets one line and its exit code, and the right one beside it passes."""

import json
import shutil

import pytest

from facade import load_registry
from sdaeverify import SDE, ProblemError, UsageError, verify

from .conftest import HEADER, SCHEME

POLICY = '[tool.sdaeverify]\nschemes = ["milstein"]\nproblems = ["gbm"]\nmeasures = ["strong"]\n'
EXPECTED = POLICY + '[[tool.sdaeverify.expected-failures]]\n{} = "{}"\nreason = "issue 12"\n'
GATE = ("gate", "-j", "1", "--tier", "smoke", "--timeout", "0", "--memory", "0", "--progress", "none")
WELL = {
    "drift": lambda t, x: -x,
    "diffusion": lambda t, x: x[:, None],
    "start": [1.0],
    "noise_dim": 1,
    "horizon": 1.0,
}

DAMAGES = {
    "empty": (lambda text: "", "the file is empty"),
    "cut": (lambda text: text[: len(text) // 2], "the file is truncated"),
    "short": (lambda text: text[: text.rindex(",")] + "\n", "cells, the heading"),
}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Return the folder of a small run."""
    folder = tmp_path_factory.mktemp("finished")
    verify("milstein", "gbm", "strong", paths=256, levels=3, out=folder)
    return folder


@pytest.mark.parametrize(
    ("kind", "name", "message"),
    [
        ("scheme", "milstein[", "cannot read 'milstein['"),
        ("scheme", "milstien", "no scheme is named milstien; did you mean milstein?"),
        ("scheme", "milstein[theta=1]", "no parameter 'theta'"),
        ("scheme", "stochastic-theta[theta=1.0]", "the label of stochastic-theta[theta=1.0] is written"),
        ("problem", "gmb", "no problem is named gmb; did you mean gbm?"),
        ("measure", "stron", "no measure is named stron; did you mean strong?"),
    ],
)
def test_an_expected_failure_that_can_never_match(call, tmp_path, kind, name, message):
    """A misspelt name in a policy is an error of usage before anything is run."""
    (tmp_path / "pyproject.toml").write_text(EXPECTED.format(kind, name))
    outcome = call(*GATE)

    (line,) = outcome.err.splitlines()
    assert (outcome.code, message in line) == (2, True)
    assert not (tmp_path / "reports" / "gate" / "run.json").exists()


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        pytest.param("scheme", "euler-maruyama", marks=pytest.mark.long),
        ("scheme", "mil*"),
        pytest.param("scheme", "stochastic-theta[theta=*]", marks=pytest.mark.long),
        ("quantity", "x[1]"),
    ],
)
def test_an_expected_failure_that_may_match(call, tmp_path, kind, name):
    """A registered name that is not selected, a glob and any quantity are no errors."""
    (tmp_path / "pyproject.toml").write_text(EXPECTED.format(kind, name))

    assert call(*GATE).code in {0, 7}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            {"truths": "exact"},
            r"truths expects a tuple of truths \(Pathwise, Moment, InvariantMean, .*\), got 'exact'",
        ),
        ({"truths": (1.0,)}, "truths expects a tuple of truths"),
        ({"source": ""}, "source expects a text that names where the problem is from, got ''"),
        ({"source": None}, "source expects a text"),
    ],
)
def test_a_problem_without_truths_or_source(wrong, message):
    """What is no truth, or no source, is one line, as for claims."""
    with pytest.raises(ProblemError, match=message):
        SDE(**{**WELL, "source": "made up", **wrong})


def test_a_scheme_without_step(call, tmp_path):
    """A class without a step is refused as it is loaded; one that prepares its step has one."""
    text = HEADER + SCHEME.format(step="return Step(state)").replace("def step", "def stepp")
    (tmp_path / "odd.py").write_text(text)
    outcome = call("list", "schemes", "--plugin", "odd.py")
    assert (outcome.code, "scheme 'odd': the class Odd has no step" in outcome.err) == (6, True)

    (tmp_path / "odd.py").write_text(
        text.replace("def stepp(self, problem, state, t, h, noise)", "def prepare(self, problem, h)")
    )
    assert call("list", "schemes", "--plugin", "odd.py").code == 0


def test_a_claim_about_a_misspelt_measure(call, tmp_path):
    """A claim about a measure that is not registered breaks the plugin file, unless a plugin is left out."""
    (tmp_path / "odd.py").write_text(HEADER + SCHEME.format(step="return Step(state)").replace('"strong"', '"stron"'))
    outcome = call("list", "schemes", "--plugin", "odd.py")

    (line,) = outcome.err.splitlines()
    assert (outcome.code, "measure 'stron', which is not registered; did you mean strong?" in line) == (6, True)


def test_a_measure_that_may_be_of_a_plugin_that_is_left_out(tmp_path):
    """A claim is only warned of where a plugin is disabled, which may register the measure."""
    (tmp_path / "odd.py").write_text(HEADER + SCHEME.format(step="return Step(state)"))
    registry = load_registry([tmp_path / "odd.py"], environ={"SDAEVERIFY_DISABLED_PLUGINS": "sdaeverify"})

    assert any("'strong', which is not registered" in warning for warning in registry.warnings)
    assert "odd" in registry.schemes


def test_strict_is_yes_or_no(call, monkeypatch):
    """A value that is neither is an error of usage."""
    monkeypatch.setenv("SDAEVERIFY_STRICT_PLUGINS", "maybe")
    outcome = call("list", "schemes")

    (line,) = outcome.err.splitlines()
    assert (outcome.code, "SDAEVERIFY_STRICT_PLUGINS expects 0 or 1, got 'maybe'" in line) == (2, True)


@pytest.mark.sweep
@pytest.mark.parametrize("command", [("choose", "gbm", "--run"), ("show",), ("compare", "finished")])
@pytest.mark.parametrize("table", ["levels.csv", "verdicts.csv"])
@pytest.mark.parametrize("kind", DAMAGES)
def test_a_damaged_table(call, tmp_path, finished, command, table, kind):
    """An empty or cut table of a run is an error of usage, which names the file."""
    shutil.copytree(finished, tmp_path / "finished")
    shutil.copytree(finished, tmp_path / "damaged")
    file, (damage, message) = tmp_path / "damaged" / table, DAMAGES[kind]
    file.write_text(damage(file.read_text()))
    outcome = call(*command, "damaged")

    if table == "levels.csv" and command[0] == "show":
        # It reads no levels unless a cell is named.
        assert outcome.code == 0
        return
    (line,) = outcome.err.splitlines()
    assert (outcome.code, table in line, message in line) == (2, True, True)


@pytest.mark.parametrize("command", [("show",), ("compare", "finished"), ("claims", "milstein"), ("cite",)])
def test_an_unknown_verdict(call, tmp_path, finished, command):
    """A word that is no verdict, as an editor or another version may leave, is named with its file."""
    for name in ("finished", "damaged"):
        shutil.copytree(finished, tmp_path / name)
    file = tmp_path / "damaged" / "verdicts.csv"
    file.write_text(file.read_text().replace(",verified,", ",proved,"))
    outcome = call(*command, "damaged")

    assert outcome.err == "sdaeverify: error: damaged/verdicts.csv has an unknown verdict: 'proved'\n"
    assert outcome.code == 2


def test_a_whole_run_is_read(call, tmp_path, finished):
    """The same run undamaged is chosen from, shown and compared."""
    shutil.copytree(finished, tmp_path / "finished")

    assert call("choose", "gbm", "--run", "finished").code == 0
    assert call("show", "finished").code == 0
    assert call("compare", "finished", "finished").code == 0


@pytest.mark.parametrize("text", ['{"model": "resnet"}', "{cut", "[1]"])
@pytest.mark.parametrize(
    "command", [("matrix", "-s", "milstein", "-p", "gbm", "-m", "strong"), GATE, ("merge", "finished")]
)
def test_a_run_of_another_program_is_not_overwritten(call, tmp_path, finished, command, text):
    """A folder whose run.json is not ours is left as it is."""
    shutil.copytree(finished, tmp_path / "finished")
    (tmp_path / "pyproject.toml").write_text(POLICY)
    out = tmp_path / "out"
    out.mkdir()
    (out / "run.json").write_text(text)
    jobs = () if command[0] in {"merge", "gate"} else ("-j", "1", "--timeout", "0", "--memory", "0")
    outcome = call(*command, *jobs, "--out", "out")

    assert (outcome.code, "out/run.json" in outcome.err) == (2, True)
    assert {file.name: file.read_text() for file in out.iterdir()} == {"run.json": text}


def test_a_run_of_ours_is_overwritten(tmp_path, finished):
    """Saving a run replaces one of this program, and refuses one of another from Python, too."""
    result = verify("milstein", "gbm", "strong", paths=256, levels=3)
    shutil.copytree(finished, tmp_path / "ours")
    result.save(tmp_path / "ours")
    assert json.loads((tmp_path / "ours" / "run.json").read_text())["arguments"] == ["sdaeverify.verify"]

    (tmp_path / "run.json").write_text("{}")
    with pytest.raises(UsageError, match="belongs to no run of this program"):
        result.save(tmp_path)
