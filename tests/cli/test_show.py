"""What is said at the end of a run, and how a finished one is looked at again."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

NO_RUN = "holds no run: cannot read verdicts.csv: No such file or directory; sdaeverify matrix --out FOLDER makes one"
REFERENCE = Path(__file__).resolve().parents[2] / "reports" / "reference"


@pytest.fixture
def finished(call_once):
    """Return a finished run of three schemes on a problem, with something undecided."""
    chosen = ("-s", "euler-maruyama,milstein,displaced-euler", "-p", "gbm", "-m", "strong,weak")
    budget = ("--paths", "400", "--levels", "8..64", "-j", "1", "--progress", "none")
    return call_once("out", "matrix", *chosen, *budget)


def test_the_end_of_a_run_is_short_and_says_where_to_look(finished):
    """The counts first, what needs attention, the schemes by measure, the page, the way to more, the exit code."""
    lines = finished.out.splitlines()
    assert lines[0].startswith("15 quantities: ")
    assert len(lines) <= 40
    assert any(line.startswith("euler-maruyama") for line in lines)
    assert "the page is out/report.html; verdicts.csv, levels.csv, columns.csv" in finished.out
    assert "sdaeverify show out [SCHEME] [PROBLEM] gives the reasons" in lines
    assert lines[-1].startswith("exit code ")


def test_a_scheme_is_shown_with_its_classes(finished, call):
    """What order conditions say of each claim stands below the cells, a line a verdict."""
    shown = " ".join(call("show", "out", "milstein").out.split())
    told = "strong order 1 verified for smooth equations of the class ode, scalar, diagonal"
    assert f"milstein: classes of equations {told}" in shown


def test_a_leading_error_is_shown_where_it_is_known(finished, call):
    """Of quadratic means and the error at T of a linear step beside their verdicts, and of no other mean or step."""
    shown = " ".join(call("show", "out", "milstein", "gbm").out.split())
    wrong = " ".join(call("show", "out", "displaced-euler", "gbm").out.split())

    assert shown.count("leading error") == 3
    assert "leading error 0.862 h without sampling, C known to" in shown
    assert "leading error -0.206 h without sampling, C known to" in shown
    assert "leading error" not in wrong


def test_what_is_the_same_of_several_measures_is_said_once(quick, call, odd_scheme):
    """A refuted step has one block for the measures without a claim, whose command names all; others their own."""
    plugin = odd_scheme("return Step(state + h)")
    quick("-s", "odd", "-p", "gbm", "-m", "stability,strong,weak", "--plugin", plugin, "--out", "out")
    lines = call("show", "out", "odd", "gbm").out.splitlines()

    assert [line for line in lines if line.startswith("odd on gbm")] == [
        "odd on gbm, stability, weak",
        "odd on gbm, strong",
    ]
    assert lines[1] == "  ○ no claim; decided by T0"
    assert any("-m stability,weak " in f"{line} " for line in lines)
    assert "  ✗ order ≥ 1.0 (sampled: ≥ 0.8); decided by T0" in lines


def test_quiet_is_the_sentence_alone(quick):
    """One line, and the same exit code."""
    outcome = quick("-s", "milstein", "-p", "gbm", "-m", "strong", "--out", "out", "-q")
    assert outcome.out.count("\n") == 1
    assert outcome.out.startswith("2 quantities: ")


def test_json_is_all_that_is_said(quick):
    """A list of objects with one meaning a key, for matrix as for show."""
    outcome = quick("-s", "milstein", "-p", "gbm", "-m", "strong", "--out", "out", "--json")
    rows = json.loads(outcome.out)
    assert [row["quantity"] for row in rows] == ["x", "x@T", *3 * ["order conditions"]]
    assert {"claim", "margin", "local_order", "path_order", "path_low", "path_high", "decided_by"} <= {*rows[0]}


def test_loud_and_quiet_contradict_each_other(quick):
    """One way to show the results at a time."""
    outcome = quick("-p", "gbm", "-q", "--json")
    told = "sdaeverify: error: contradictory options: choose one of --quiet and --json\n"
    assert (outcome.code, outcome.err) == (2, told)


def test_no_page_where_none_is_wanted(quick):
    """An earlier page is removed with it: its numbers are no longer those of the tables."""
    chosen = ("-s", "milstein", "-p", "gbm", "-m", "strong", "--out", "out")
    quick(*chosen)
    assert Path("out/report.html").is_file()
    outcome = quick(*chosen, "--no-html")
    assert not Path("out/report.html").exists()
    assert "the page is" not in outcome.out


@pytest.mark.long
def test_the_last_failures_alone_are_run_again(finished, quick):
    """What was verified is left alone."""
    quick("-s", "milstein", "-p", "gbm", "-m", "strong", "--out", "out")
    quick("-p", "gbm", "-m", "strong,weak", "--out", "out", "--lf")
    selection = json.loads(Path("out/run.json").read_text())["selection"]
    assert selection == {"schemes": ["milstein"], "problems": ["gbm"], "measures": ["strong"]}


def test_there_are_no_last_failures_where_all_is_verified(finished, call):
    """Nothing to measure, and why."""
    outcome = call("matrix", "-s", "milstein", "-p", "gbm", "-m", "strong", "--out", "out", "--lf", "-j", "1")
    assert (outcome.code, outcome.err) == (5, "sdaeverify: error: nothing to measure: all was verified in out\n")


def test_a_run_ends_with_the_first_refutation_if_asked(quick, odd_scheme):
    """The other problems are not run, and their rows say why."""
    plugin = odd_scheme("return Step(state + h)")
    outcome = quick("--plugin", plugin, "-s", "odd", "-p", "gbm,ou,linear-test", "-m", "strong", "--out", "out", "-x")
    assert outcome.code == 1
    assert "not run" in outcome.out
    assert "the run ended at the first refuted claim (-x)" in Path("out/verdicts.csv").read_text()


def test_show_ends_like_the_run(finished, call):
    """The same sentence, the same lines on what needs attention and on the schemes."""
    shown, run = call("show", "out").out.splitlines(), finished.out.splitlines()
    assert (
        shown[: shown.index("the page is out/report.html")] == run[: run.index(next(x for x in run if "page" in x))]
    )


def test_show_tells_of_a_cell_why_and_how_again(finished, call):
    """Claim, margin, orders, tier and guard of each quantity, the command, and why the rest does not apply."""
    told = call("show", "out", "milstein", "gbm").out
    words = " ".join(told.split())
    assert "x: order ≥ 1.0 (sampled: ≥ 0.8); local order 1.000; order along paths" in words
    assert "decided by T1; guarded by paths, exact solution" in words
    assert "again: python -m sdaeverify matrix -s milstein -p gbm -m strong" in told


def test_show_tells_of_an_empty_cell_why(call):
    """A dot in the matrix has a reason, and show tells it."""
    told = call("show", str(REFERENCE), "baoab", "circle").out
    assert "needs a Langevin; this problem is an SDE" in " ".join(told.split())


def test_show_of_a_scheme_that_solves_nothing_of_a_run_tells_why(quick, call):
    """Where a scheme has no quantity, the reason of its refusals stands in the place of a table."""
    quick("-s", "milstein,baoab", "-p", "gbm", "-m", "strong", "--out", "out")
    told = " ".join(call("show", "out", "baoab").out.split())

    assert "1 cell does not apply" in told
    assert "does not apply: baoab on gbm, strong: needs a Langevin; this problem is an SDE" in told


def test_show_of_a_scheme_is_a_table_a_problem(finished, call):
    """Quantity, claim, local order, order along paths with its interval and the least that paths accept, tier.

    One step accepts from another order on, which its reason names: a note below the table says so.
    """
    told = call("show", "out", "milstein").out
    assert "milstein on gbm" in told
    assert max(map(len, told.splitlines())) <= 80
    (row,) = [line.split() for line in told.splitlines() if line.startswith("✓  strong x ")]
    assert [*row[3:6], *row[-2:]] == ["≥", "1.0", "1.00", "0.8", "T1"]
    note = "T1: from one step, without sampling, with the one-step tolerance that the reason names"
    assert note in " ".join(told.split())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), f"reports/latest {NO_RUN}"),
        (
            ("nowhere",),
            "nowhere is not a folder, and there is no run in reports/latest in which it could be a scheme",
        ),
        (("nowhere/",), f"nowhere {NO_RUN}"),
        ((str(REFERENCE), "milstien"), f"nothing in {REFERENCE} is about milstien; did you mean milstein?"),
        (
            (str(REFERENCE), "milstein", "gbm", "-m", "srtong"),
            f"nothing in {REFERENCE} is about milstein on gbm, srtong; did you mean strong?",
        ),
    ],
)
def test_what_is_not_there_is_one_line(call, words, message):
    """A folder without a run and a name without rows are errors of the user."""
    outcome = call("show", *words)
    assert (outcome.code, outcome.out, outcome.err) == (2, "", f"sdaeverify: error: {message}\n")


@pytest.mark.long
def test_the_first_contact_is_a_table_and_a_page(call):
    """Three schemes on two problems: claim, order of one step, order along paths, verdict, tier, and a page."""
    outcome = call("demo", "--out", "first")
    lines = outcome.out.splitlines()
    assert outcome.code == 0
    assert lines[1] == "euler-maruyama on gbm"
    assert lines[2].split() == ["quantity", "claim", "one", "step", "along", "paths", "accepted", "≥", "by"]
    assert max(map(len, lines)) <= 80
    assert "half-explicit-euler on pendulum" in lines
    assert "The page with the pictures is first/report.html: open it in a browser." in lines
    assert Path("first/report.html").is_file()
    # What the columns mean is told once, below the last table.
    assert sum(line.startswith("T1: from one step") for line in lines) == 1


def test_a_shell_completes_commands(call, monkeypatch):
    """The script that a shell reads, and what it is told."""
    monkeypatch.setenv("_SDAEVERIFY_COMPLETE", "bash_source")
    assert "complete -o nosort -F _sdaeverify_completion sdaeverify" in call().out
    monkeypatch.setenv("_SDAEVERIFY_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", "sdaeverify ma")
    monkeypatch.setenv("COMP_CWORD", "1")
    assert call().out == "plain,matrix\n"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("matrix -s half-ex", ["half-explicit-euler"]),
        ("matrix -s heun,half-ex", ["heun,half-explicit-euler"]),
        ("matrix -p noisy-c", ["noisy-circuit"]),
        ("gate -m stro", ["strong"]),
        ("choose noisy-c", ["noisy-circuit"]),
        ("info noisy-c", ["noisy-circuit"]),
        ("check half-ex", ["half-explicit-euler"]),
        ("matrix -s nobody", []),
        ("matrix --plugin missing.py -s half-ex", []),
    ],
)
def test_a_shell_completes_names(call, monkeypatch, words, told):
    """Of schemes, problems and measures, also the last one of a list; a plugin that is missing completes nothing."""
    monkeypatch.setenv("_SDAEVERIFY_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", f"sdaeverify {words}")
    monkeypatch.setenv("COMP_CWORD", str(len(words.split())))
    assert call().out.split() == [f"plain,{name}" for name in told]


@pytest.mark.parametrize("given", [{}, {"_SDAEVERIFY_COMPLETE": "bash_complete"}], ids=["version", "completion"])
def test_a_short_answer_loads_no_library_of_numbers(given):
    """The version and the names of commands are told before numpy is imported, which takes longer than all else."""
    shell = {**os.environ, "COMP_WORDS": "sdaeverify ma", "COMP_CWORD": "1", **given}
    words = [sys.executable, "-X", "importtime", "-m", "sdaeverify", "--version"]
    told = subprocess.run(words, env=shell, capture_output=True, text=True, check=True)
    assert told.stdout.startswith("plain,matrix" if given else "sdaeverify ")
    assert "click" in told.stderr
    assert "numpy" not in told.stderr


def test_plugins_load_without_pandas():
    """Only tables need it: a list, and each worker process, starts a quarter of a second sooner."""
    words = [sys.executable, "-X", "importtime", "-m", "sdaeverify", "list", "measures"]
    told = subprocess.run(words, capture_output=True, text=True, check=True)
    assert "numpy" in told.stderr
    assert "pandas" not in told.stderr


def test_info_is_told_to_programs(call):
    """A list of records: what a scheme and a problem say of themselves."""
    (scheme,) = json.loads(call("info", "milstein", "--json").out)
    assert (scheme["kind"], scheme["form"]) == ("scheme", "SDE")
    assert {"measure", "claim", "margin", "source"} <= {*scheme["claims"][0]}
    (problem,) = json.loads(call("info", "pendulum[c_g=0]", "--json").out)
    assert problem["parameters"]["c_g"] == "0.0"
    assert problem["truths"]
    assert problem["controls"]
