"""A nightly gate with a hunt in its policy."""

import json
from types import SimpleNamespace

import pytest

import sdaeverify
from facade import Policy, execute, load_registry
from sdaeverify.errors import PluginError
from sdaeverify.gate import hunted
from sdaeverify.gate.hunted import Hunted

POLICY = """[tool.sdaeverify]
schemes = ["{scheme}"]
problems = ["ou"]
measures = ["strong"]
tier = "nightly"
hunt = "10 s"
"""
PLUGIN = """from hunt.wrong_schemes import LaterSecondStage
from sdaeverify import hookimpl

@hookimpl
def sdaeverify_schemes():
    return [LaterSecondStage()]
"""


def run_gate(tmp_path, scheme):
    """Return the exit code of a gate, and its report."""
    (tmp_path / "plugin.py").write_text(PLUGIN, encoding="utf-8")
    (tmp_path / "pyproject.toml").write_text(POLICY.format(scheme=scheme), encoding="utf-8")
    given = ["--config", str(tmp_path / "pyproject.toml"), "--plugin", str(tmp_path / "plugin.py")]
    code = execute(["gate", *given, "--out", str(tmp_path / "gate"), "-j", "1", "--progress", "none"])
    return code, json.loads((tmp_path / "gate/gate.json").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_a_hunt_makes_a_gate_red_that_its_problems_leave_green(tmp_path, capsys):
    """All claims pass on the problem of the policy; the hunt finds another one, and keeps it as plugin and test."""
    code, report = run_gate(tmp_path, "later-second-stage")

    printed = capsys.readouterr().out
    assert set(report["counts"]) == {"passed"}
    assert code == 1
    assert "later-second-stage, strong, SDE: order >= 1.5" in printed
    assert "hunt of 10 s: " in printed
    found = [tmp_path / "plugin.py", tmp_path / "gate/counterexample.py"]
    rows = sdaeverify.verify("later-second-stage", "counterexample", "strong", plugins=found).verdicts
    assert (rows.verdict == "refuted").any()
    assert (tmp_path / "gate/test_counterexample.py").exists()


@pytest.mark.slow
def test_a_hunt_leaves_the_gate_of_a_right_scheme_green(tmp_path, capsys):
    """It says how many examples were looked at."""
    code, _ = run_gate(tmp_path, "sri1w1")

    assert code == 0
    assert "0 claims refuted" in capsys.readouterr().out


def test_a_gate_does_without_the_hunt(monkeypatch, tmp_path):
    """Where an installation has left it out or disabled it, the report says so, and nothing is red for it."""
    monkeypatch.setattr(hunted, "enabled_entry_points", lambda group: [])
    found = hunted.search(load_registry(environ={}), Policy(tier="nightly", hunt="10 s"), tmp_path)

    assert found == Hunted(notes=("hunt of 10 s: this installation has no hunt",))


def test_a_disabled_hunt_is_not_called(monkeypatch, tmp_path):
    """The name of its entry point is one that the environment can disable."""
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", "hunt")
    found = hunted.search(load_registry(environ={}), Policy(tier="nightly", hunt="10 s"), tmp_path)

    assert found.notes == ("hunt of 10 s: this installation has no hunt",)


@pytest.mark.parametrize("answer", [3, {"notes": [1]}, {"attacks": [{"scheme": "a"}]}])
def test_a_hunt_that_answers_otherwise_is_broken(monkeypatch, tmp_path, answer):
    """What a plugin returns is read as the report of a gate, and costs one line where it is not."""
    odd = SimpleNamespace(name="odd", value="odd:hunt", dist=None, load=lambda: lambda schemes, **asked: answer)
    monkeypatch.setattr(hunted, "enabled_entry_points", lambda group: [odd])
    policy = Policy(tier="nightly", hunt="10 s", schemes=("milstein",))
    with pytest.raises(PluginError, match="the hunt of plugin odd"):
        hunted.search(load_registry(environ={}), policy, tmp_path)
