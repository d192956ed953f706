"""The command ``reproduce``: what it lists, runs, prints and writes, and its exit code."""

import json
import re
import sys
from pathlib import Path

import pytest

from evidence import rows_of
from facade import ExperimentRun, with_error

pytestmark = pytest.mark.long

ROWS = """
from sdaeverify_lab.papers import FineRun, MeanTable, Printed, Row

def row(steps, digits="1.5625", **other):
    return Row(**{{"problem": "gbm[b=0]", "scheme": "euler-maruyama", "steps": steps, "observable": "x",
                   "printed": Printed(digits, 100)}} | other)

@hookimpl
def sdaeverify_experiments():
    return [MeanTable(name="mine", title="Euler without noise", source="My paper, Table 7", rows=({rows}),
                       paths=20, notes=("Read this first.",))]
"""


@pytest.fixture
def mine(write):
    """Write a plugin with the experiment ``mine``."""
    return lambda rows="row(2),", more="": write(ROWS.format(rows=rows) + more)


@pytest.fixture
def reproduce(call):
    """Run ``reproduce`` in this process, in silence."""
    return lambda *words: call("reproduce", "-j", "1", "--progress", "none", *words)


def test_list(reproduce, mine):
    """All experiments are listed with what they show, those of others, too."""
    outcome = reproduce("--list", "--plugin", mine())

    assert (outcome.code, outcome.err) == (0, "")
    names = [line for line in outcome.out.splitlines() if not line.startswith(" ")]
    assert names == sorted(names)
    assert {"laurent-2022-figure-1", "laurent-2022-table-1", "mine"} <= set(names)
    lines = outcome.out.splitlines()
    place = lines.index("mine")
    assert lines[place + 1 : place + 3] == ["    Euler without noise", "    My paper, Table 7; 20 paths"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("nosuch",), "unknown experiment 'nosuch'; --list shows all"),
        (("laurent-2022-tabel-1",), "'laurent-2022-tabel-1'; did you mean laurent-2022-table-1? --list shows all"),
        ((), "reproduce expects the name of an experiment; --list shows all"),
        (("laurent-2022-table-1", "--paths", "1"), "paths must be at least 2"),
        (("laurent-2022-table-1", "--seed", "-1"), "seed must be between 0 and 2^63 - 1, got -1"),
        (("laurent-2022-table-1", "--paths", "2", "--paths", "3"), "contradictory options: --paths"),
    ],
)
def test_wrong_words(reproduce, words, message):
    """Wrong words are one line on stderr; nothing is run or written."""
    outcome = reproduce(*words)

    assert (outcome.code, outcome.out) == (2, "")
    assert message in outcome.err
    assert outcome.err.count("\n") == 1
    assert not list(Path().iterdir())


def test_table(reproduce, mine):
    """Print, mean and exact value stand side by side, with where they disagree; a disagreement is no failure."""
    outcome = reproduce("mine", "--plugin", mine("row(2), row(4, '1.7')"))

    assert (outcome.code, outcome.err) == (0, "")
    heading, _, _, first, second = outcome.out.splitlines()[1:6]
    assert heading == "euler-maruyama on gbm[b=0]"
    assert first.split() == ["0.5", "x", "1.5625", "1.6487213", "1.5625", "yes", "NO"]
    assert second.split()[-3:] == ["1.7", "NO", "NO"]
    assert "Read this first." in outcome.out
    assert outcome.out.splitlines()[-1] == "exit code 0: no claim is refuted, and no check fails"


def test_columns(reproduce, mine):
    """A column that says nothing in any row is left out, and one that does is headed; lines have 80 columns."""
    few = reproduce("mine", "--plugin", mine("row(2, printed=None), row(4, printed=None)"))
    some = reproduce("mine", "--plugin", mine("row(2), row(4, at=1, printed=None)"))

    assert few.out.splitlines()[2].split() == ["h", "mean", "of", "here", "exact"]
    assert some.out.splitlines()[2].split()[:7] == ["h", "mean", "of", "t", "here", "exact", "paper"]
    assert max(map(len, some.out.splitlines()[1:6])) <= 80


def test_error_against_a_reference(reproduce, mine):
    """An error is named by its reference, small numbers keep their digits, and three step sizes make an order."""
    fine = "reference=FineRun('euler-maruyama', 512), printed=None, problem='gbm'"
    outcome = reproduce("mine", "--plugin", mine(", ".join(f"row({steps}, {fine})" for steps in (16, 32, 64))))

    assert (outcome.code, outcome.err) == (0, "")
    rows = [line.split() for line in outcome.out.splitlines() if line.startswith("0.0")]
    assert [" ".join(words[1:4]) for words in rows] == ["(x - ref)^2"] * 3
    found = rows_of("reports/mine/table.csv")
    for words, row in zip(rows, found, strict=True):
        shown = re.fullmatch(r"(\d\.?\d*)\((\d+)\)(e-\d\d)?", words[4])
        assert float(shown[1] + (shown[3] or "")) == pytest.approx(float(row["value"]), rel=0.05)
        assert (row["reference_scheme"], row["reference_steps"]) == ("euler-maruyama", "512")
    assert "ref: euler-maruyama with 512 steps to the final time, on the same Brownian paths of gbm" in outcome.out
    words = r"euler-maruyama on gbm: order (\S+) \+- \S+ of the root mean square of x - ref, from 3 step sizes"
    order = float(re.search(words, outcome.out)[1])
    assert order == pytest.approx(0.5, abs=0.2)
    assert any(
        f"order {order:.4f}" in remark for remark in json.loads(Path("reports/mine/run.json").read_text())["remarks"]
    )


@pytest.mark.parametrize(
    ("value", "std_error", "text"),
    [
        (2.0062, 0.0012, "2.0062(12)"),
        (3.34e-7, 3.5e-8, "3.34(35)e-07"),
        (-4.5375e-5, 2.0e-8, "-4.5375(20)e-05"),
        (1e-9, 3.456e-8, "0.1(35)e-08"),
        (0.0134, 0.01, "0.013(10)"),
        (10.73, 4.0, "10.73 +- 4"),
        (0.25, 0.0, "0.25"),
        (float("nan"), 1.0, ""),
    ],
)
def test_numbers_with_errors(value, std_error, text):
    """A number has the digits up to the second of its standard error, which stands in brackets."""
    assert with_error(value, std_error) == text


def test_files(reproduce, mine):
    """The table and what it was made with are in a folder of the experiment's name, or in the one that is given."""
    plugin = mine()
    reproduce("mine", "--plugin", plugin)
    reproduce("mine", "--plugin", plugin, "--paths", "30", "--seed", "5", "--out", "elsewhere")

    (default,), (given,) = rows_of("reports/mine/table.csv"), rows_of("elsewhere/table.csv")
    assert (default["paths"], given["paths"]) == ("20", "30")
    assert float(given["value"]) == 1.5625
    about = json.loads(Path("elsewhere/run.json").read_text())
    assert (about["experiment"], about["paths"], about["seed"]) == ("mine", 30, 5)
    assert about["arguments"][:2] == ["sdaeverify", "reproduce"]
    assert "numpy" in about["versions"]


def test_several_experiments(reproduce, mine):
    """Names and globs may be several; each experiment has a folder of its own, and the worst exit code counts."""
    outcome = reproduce(
        "mine", "lindner-2017-f*", "--plugin", mine("row(2, scheme='half-explicit-euler'),"), "--out", "o"
    )

    assert outcome.code == 3
    assert {path.name for path in Path("o").iterdir()} == {"mine", "lindner-2017-figure-5-1"}
    assert json.loads(Path("o/lindner-2017-figure-5-1/run.json").read_text())["budget"] == "smoke"
    assert outcome.out.count("exit code") == 1


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_picture(reproduce, suffix):
    """A figure has a picture beside its table, in the format that is asked for."""
    pytest.importorskip("matplotlib")
    outcome = reproduce(
        "lindner-2017-estimate-3-17", "--out", "o", *(() if suffix == "svg" else ("--format", suffix))
    )

    assert outcome.code == 0
    assert {path.name for path in Path("o").iterdir()} == {"table.csv", "run.json", "report.html", f"figure.{suffix}"}
    assert f"table.csv, run.json, report.html, figure.{suffix} are in o" in outcome.out


def test_no_matplotlib(reproduce, monkeypatch):
    """Without matplotlib there is a table, and a line that says what is missing."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    outcome = reproduce("lindner-2017-estimate-3-17", "--out", "o")

    assert (outcome.code, outcome.err) == (0, "")
    assert "no picture without matplotlib: pip install 'sdaeverify[plot]'" in outcome.out
    assert {path.name for path in Path("o").iterdir()} == {"table.csv", "run.json", "report.html"}


BROKEN = """
from sdaeverify_lab.papers import Experiment, SchemeRun

class Broken(Experiment):
    name, title, source, paths = "broken", "t", "s", 2

    def work(self, budget):
        return {{"a": SchemeRun(problem="gbm", scheme="{scheme}", steps=2)}}

    def exhibit(self, evidence):
        return evidence.values("a", "x"){more}

@hookimpl
def sdaeverify_experiments():
    return [Broken()]
"""


@pytest.mark.parametrize(
    ("scheme", "more", "message"),
    [
        ("half-explicit-euler", "", "a: scheme half-explicit-euler: needs a HolonomicSDAE"),
        ("milstein", " / 0", "broken: "),
    ],
)
def test_exhibit_that_cannot_be_made(reproduce, write, scheme, more, message):
    """A run that fails, or an exhibit that raises, is one line, and the exit code tells."""
    outcome = reproduce("broken", "--plugin", write(BROKEN.format(scheme=scheme, more=more)))

    assert outcome.code == 3
    assert message in outcome.out
    assert "Traceback" not in outcome.out + outcome.err


def test_worker_processes(call, mine):
    """Worker processes load the plugin, and change no digit."""
    plugin = mine("row(2, problem='gbm'), row(8, problem='gbm')")
    for jobs in "12":
        words = ("--paths", "1100", "-j", jobs, "--out", jobs, "--progress", "none", "--plugin", plugin)
        assert call("reproduce", "mine", *words).code == 0

    assert Path("1/table.csv").read_text() == Path("2/table.csv").read_text()


def test_interrupt(reproduce, mine, monkeypatch):
    """What was finished before an interrupt is saved and shown."""
    run = ExperimentRun.run

    def interrupted(self, executor=None, window=1):
        events = run(self, executor, window)
        yield next(events)
        raise KeyboardInterrupt

    monkeypatch.setattr(ExperimentRun, "run", interrupted)
    outcome = reproduce("mine", "--paths", "700", "--plugin", mine("row(2), row(4, problem='ou')"))

    assert outcome.code == 130
    assert outcome.out.splitlines()[-1] == "exit code 130: interrupted; what was finished is saved"
    assert "euler-maruyama on ou, h = 0.25: not reached" in outcome.out
    assert [row["paths"] for row in rows_of("reports/mine/table.csv")] == ["500", "0"]


def test_broken_plugin(reproduce, mine):
    """A plugin whose experiments cannot be used is refused in one line."""
    outcome = reproduce("--list", "--plugin", mine(more="\nsdaeverify_experiments = hookimpl(lambda: ['mine'])"))

    assert outcome.code == 6
    assert "expects each to be Experiment, got an object of type str" in outcome.err
    assert outcome.err.count("\n") == 1
