"""The command ``selftest``: what it runs, prints and writes, and its exit code."""

from pathlib import Path

import pytest

from evidence import rows_of
from facade import Study

BUG = """
class Odd(Scheme):
    name: ClassVar[str] = "planted-odd"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        B = problem.diffusion(t, state)
        return Step(state + h * problem.drift(t, state) + {factor} * np.einsum("dlp,lp->dp", B, noise.dW))

@hookimpl
def sdaeverify_planted():
    return [Planted(bug="noise times {factor}", scheme=Odd(), problem="gbm")]
"""


@pytest.fixture
def odd_bug(write):
    """Write a plugin with the planted bug ``planted-odd``, noise times a factor."""

    def put(factor="1.0"):
        return write("from sdaeverify_lab import Planted\n" + BUG.format(factor=factor))

    return put


@pytest.fixture
def selftest(call):
    """Run ``selftest`` in this process, in silence."""
    return lambda *words: call("selftest", "-j", "1", "--paths", "256", "--progress", "none", *words)


@pytest.mark.long
@pytest.mark.parametrize("further", [pytest.param((), id=""), pytest.param(("--out", "result"), id="out")])
def test_bug_that_is_refuted(selftest, odd_bug, further):
    """A mark under the check that did it, and success; with --out alone a row for each bug is written."""
    outcome = selftest("--only", "planted-odd", "--plugin", odd_bug(factor="1.1"), *further)

    assert outcome.code == 0
    row = next(line for line in outcome.out.splitlines() if line.startswith("noise times 1.1"))
    assert row.split()[-1] in "✓x"
    assert "1 of 1 planted bugs are refuted" in outcome.out
    assert outcome.out.splitlines()[-1].endswith("exit code 0: no claim is refuted, and no check fails")
    assert outcome.err == ""
    assert sorted(path.name for path in Path().iterdir()) == ["odd_plugin.py", "result"][: 1 + bool(further)]
    if further:
        (row,) = rows_of("result/kill.csv")
        assert (row["bug"], row["scheme"], row["problem"]) == ("noise times 1.1", "planted-odd", "gbm")
        kills = [name for name, value in row.items() if value == "1"]
        assert (row["outcome"], kills) == ("refuted", ["strong TA", "contract T0"])


def test_classes_are_not_tested_where_a_cell_refutes(selftest, odd_bug):
    """With --quick the mark of the contract is the only one, and success is the same."""
    outcome = selftest("--only", "planted-odd", "--plugin", odd_bug(factor="1.1"), "--quick", "--out", "result")

    assert (outcome.code, outcome.err) == (0, "")
    (row,) = rows_of("result/kill.csv")
    assert [name for name, value in row.items() if value == "1"] == ["contract T0"]


@pytest.mark.long
def test_classes_are_tested_where_no_cell_refutes(selftest):
    """With --quick a bug that the steps on its problem do not show is refuted by order conditions all the same."""
    outcome = selftest("--only", "planted-platen-general-old-drift", "--quick", "--out", "result")

    assert outcome.code == 0
    rows = [row for row in rows_of("result/kill.csv") if row["problem"] == "noncommuting"]
    assert [[name for name, value in row.items() if value == "1"] for row in rows] == [["weak TA"]]


def test_bug_that_survives(selftest, odd_bug):
    """A scheme that is right, passed off as a bug, is a survivor by name, and the test fails."""
    outcome = selftest("--only", "planted-odd", "--plugin", odd_bug())

    assert outcome.code == 1
    assert "survives: noise times 1.0 (planted-odd on gbm): strong x" in outcome.out
    assert "0 of 1 planted bugs are refuted" in outcome.out


def test_interrupt(selftest, odd_bug, monkeypatch):
    """An interrupt ends it in one line."""

    def run(self, executor=None, window=1):
        raise KeyboardInterrupt

    monkeypatch.setattr(Study, "run", run)
    outcome = selftest("--only", "planted-odd", "--plugin", odd_bug())

    assert outcome.code == 130
    assert outcome.err == "sdaeverify: interrupted\n"
    assert outcome.out == ""


def test_planted_schemes_are_no_schemes(call, monkeypatch):
    """A planted scheme is neither listed nor selected among the schemes; plugins say how many they bring."""
    monkeypatch.delenv("COLUMNS")
    listed = call("list", "schemes").out
    plugins = [line.split() for line in call("list", "plugins").out.splitlines() if "planted.higher_orders" in line]

    assert "planted" not in "".join(line.split()[0] for line in listed.splitlines() if line.strip())
    assert plugins[0][-3:] == ["loaded", "29", "planted"]
    assert call("matrix", "-s", "planted-*", "--dry-run").code == 2
