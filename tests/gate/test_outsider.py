"""An examination of others, whose objects are no problems, through everything that reads verdicts."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from evidence import rows_of
from facade import ExitCode, execute

pytestmark = pytest.mark.long

PLUGIN = Path(__file__).parents[1] / "thirdparty/stages/src/sdaeverify_stages/__init__.py"
LONGEST = 80
POLICY = """
[tool.sdaeverify]
schemes = ["staged-euler"]
problems = ["gbm"]
measures = ["calls"]
tier = "smoke"

[tool.sdaeverify.examinations.calls]
schemes = ["staged-euler"]
"""
OBJECTS = ("steps.8", "steps.16")
TESTS = """
import pytest
from sdaeverify.testing import parametrize_with_examinations

@parametrize_with_examinations({"calls": {"schemes": ["staged-euler"]}})
def test_calls(subject, check):
    check(subject)
"""


@pytest.fixture
def gate(tmp_path, monkeypatch, capsys):
    """Run a command line in a folder with a policy; return its exit code and what is said."""
    monkeypatch.chdir(tmp_path)
    Path("pyproject.toml").write_text(POLICY)
    Path("stages.py").write_text(PLUGIN.read_text())

    def run(*words):
        code = execute(list(words))
        return ExitCode(code), " ".join(capsys.readouterr().out.split())

    return run


def wrong():
    """Let the scheme call its drift twice."""
    text = PLUGIN.read_text()
    Path("stages.py").write_text(text.replace("range(self.stages)", "range(2)"))


def test_it_is_short():
    """With its scheme and its hooks it has at most 80 lines that are not blank."""
    lines = [line for line in PLUGIN.read_text(encoding="utf-8").splitlines() if line.strip()]
    assert len(lines) <= LONGEST


def test_its_rows_are_everywhere(gate):
    """Table, page, show, claims, gate.json, lock file, comparison and exit code have them as those of any cell."""
    words = ("gate", "--plugin", "stages.py", "--progress", "none", "-j", "1")
    code, _ = gate(*words, "--write-lock", "--out", "right")

    assert code is ExitCode.OK
    found = [row for row in rows_of(Path("right/verdicts.csv")) if row["measure"] == "calls"]
    told = [(row["problem"], row["verdict"], row["value"]) for row in found]
    assert told == [(each, "verified", "1.0") for each in OBJECTS]
    assert all(each in Path("right/report.html").read_text() for each in OBJECTS)
    assert "steps.8, calls ✓ drift: one call" in gate("show", "right", "staged-euler", "steps.8")[1]
    assert "staged-euler, calls one call: on problems 2 verified" in gate("claims", "staged-euler", "right")[1]
    locked = json.loads(Path("sdaeverify.lock").read_text())["tiers"]["smoke"]["staged-euler"]
    assert {*locked} == {*OBJECTS}

    wrong()
    code, said = gate(*words, "--against", "right", "--out", "wrong")

    assert code is ExitCode.REFUTED
    assert "refuted: staged-euler on steps.8, calls drift: claimed one call" in said
    assert "changed: staged-euler on steps.8, calls drift: verified before, refuted now" in said
    outcomes = json.loads(Path("wrong/gate.json").read_text())["outcomes"]
    assert {(row["problem"], row["status"]) for row in outcomes} == {(each, "failed") for each in OBJECTS}
    code, said = gate("compare", "right", "wrong", "--plugin", "stages.py")
    assert code is ExitCode.REFUTED
    assert "staged-euler on steps.8, calls drift: verified -> refuted" in said


def test_a_locked_object_is_missed(gate):
    """What is examined no more is no longer tested: the gate is red."""
    gate("gate", "--plugin", "stages.py", "--progress", "none", "-j", "1", "--write-lock")
    Path("pyproject.toml").write_text(POLICY.partition("[tool.sdaeverify.examinations")[0])
    code, said = gate("gate", "--plugin", "stages.py", "--progress", "none", "-j", "1")

    assert code is ExitCode.NOTHING
    assert "no longer tested: staged-euler on steps.8, calls drift: one call" in said
    assert "not tested: staged-euler: calls one call" in said


def test_an_examination_that_raises_costs_one_line(gate, capsys):
    """A mistake in the code of a plugin is no defect of the program."""
    text = PLUGIN.read_text()
    Path("stages.py").write_text(text.replace("verdict, why = ", "raise ValueError('no'); verdict, why = "))
    code = execute(["gate", "--plugin", "stages.py", "--progress", "none", "-j", "1"])
    said = capsys.readouterr().err

    assert code == ExitCode.NOT_MEASURED
    assert "an examination raises ValueError: no (stages.py:70); nothing is gated" in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(("stages", "failed"), [("self.stages", 0), ("2", 1)])
def test_it_is_a_test_and_in_the_file_of_junit(stages, failed, pytester, monkeypatch):
    """The kit makes a test of it, whose failure says what is refuted, with the command that finds it again."""
    pytester.makepyfile(stages=PLUGIN.read_text().replace("range(self.stages)", f"range({stages})"))
    pytester.makepyfile(test_calls=TESTS)
    entry = pytester.path / "stages-1.0.dist-info"
    entry.mkdir()
    (entry / "METADATA").write_text("Metadata-Version: 2.1\nName: stages\nVersion: 1.0\n")
    (entry / "entry_points.txt").write_text("[sdaeverify]\nstages = stages\n")
    monkeypatch.setenv("PYTHONPATH", str(pytester.path))
    done = pytester.runpytest_subprocess("--junitxml=junit.xml", "-p", "no:cacheprovider", "-W", "error")
    done.assert_outcomes(passed=1 - failed, failed=failed)
    (case,) = ElementTree.parse(pytester.path / "junit.xml").iter("testcase")
    assert case.get("name") == "test_calls[calls]"
    told = "".join(each.get("message", "") + (each.text or "") for each in case.iter("failure"))
    assert ("refuted: staged-euler on steps.8, calls drift: claimed one call" in told) == bool(failed)
