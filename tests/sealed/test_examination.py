"""Sealed solvers in a gate: outcomes, lock and commands."""

from pathlib import Path

import pytest

from facade import ExitCode, execute

pytestmark = pytest.mark.long

POLICY = """
[tool.sdaeverify]
schemes = ["euler-maruyama"]
problems = ["gbm", "ou"]
measures = ["strong"]
tier = "smoke"

[tool.sdaeverify.examinations.sealed]
solvers = ["{solver}"]
problems = ["ou"]
paths = {paths}
looks = 1
"""


@pytest.fixture
def gate(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def words(policy, *given):
        Path("pyproject.toml").write_text(policy)
        code = execute(["gate", *given])
        return ExitCode(code), capsys.readouterr()

    return words


def test_what_is_refuted_fails_a_gate(gate):
    """A solver with a wrong limit is refuted beside the schemes, with the command that measures it again."""
    code, said = gate(POLICY.format(solver="planted-half-drift", paths=32768))

    assert code is ExitCode.REFUTED
    assert "planted-half-drift" in said.out
    assert "sdaeverify sealed planted-half-drift -p ou --paths 32768 --looks 1 --seed" in said.out


def test_a_failed_check_refutes_each_kind_of_claim(gate):
    """A solver that ignores its seed has neither its weak order nor its invariant law verified."""
    code, _ = gate(POLICY.format(solver="planted-seedless", paths=8192))
    found = Path("reports/gate/verdicts.csv").read_text()

    assert code is ExitCode.REFUTED
    refuted = [line for line in found.splitlines() if "planted-seedless" in line and ",refuted," in line]
    assert {line.split(",")[2] for line in refuted} == {"weak", "invariant"}
    assert all("give the same numbers" in line for line in refuted)


def test_a_claim_that_is_verified_goes_into_the_lock(gate):
    """What is verified of a right solver is in the lock file, by measure and quantity."""
    code, _ = gate(POLICY.format(solver="own-euler", paths=131072), "--write-lock")

    assert code is ExitCode.OK
    locked = Path("sdaeverify.lock").read_text()
    assert "own-euler" in locked
    assert "invariant" in locked


def test_a_wrong_table_is_told(gate):
    """One line names what is expected."""
    code, said = gate(POLICY.format(solver="own-euler", paths=8192).replace("looks", "look"))

    assert code is ExitCode.USAGE
    assert "unknown field `look`" in said.err
