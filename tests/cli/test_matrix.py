"""The command ``matrix``: options, progress, tables, files, reproducibility."""

import json
import re
import shlex
from pathlib import Path

import pytest

from evidence import rows_of
from facade import ExitCode, Processes
from sdaeverify import Settings
from sdaeverify.report.tables.command import command_of, reproduce

Rows = list[dict[str, str]]


def rows(folder: str | Path, name: str = "verdicts.csv") -> Rows:
    """Return the rows of a table as text, the times left out."""
    found = rows_of(Path(folder) / name)
    return [{key: text for key, text in row.items() if not key.endswith("seconds")} for row in found]


def test_defaults_in_the_help(call):
    """The help shows the defaults of the settings."""
    settings = Settings()
    text = " ".join(call("matrix", "--help").out.split())

    def default(option: str) -> str:
        return re.search(rf"{option} .*?\[default: (.*?)\]", text).group(1)

    assert default("--paths") == str(settings.paths)
    assert default("--levels") == f"{settings.steps[0]}..{settings.steps[-1]}"
    assert default("--seed") == str(settings.seed)
    assert default("--confidence") == str(settings.confidence)
    assert default("--block") == str(settings.block)
    assert default("--out") == "reports/latest"


def test_defaults_are_the_settings(quick, call):
    """Without options the settings are those of the Python interface."""
    outcome = call("matrix", "--dry-run", "-p", "gbm", "-j", "1")
    settings = Settings()

    budget = f"{settings.paths} paths, {settings.steps[0]}..{settings.steps[-1]} steps, seed {settings.seed}"
    assert outcome.out.splitlines()[-1].endswith(budget)


@pytest.mark.parametrize("option", ["-h", "--help"])
@pytest.mark.parametrize("command", [[], ["matrix"], ["list"], ["info"]])
def test_help_everywhere(call, command, option):
    """Every command has both forms of help."""
    outcome = call(*command, option)

    assert outcome.code == 0
    assert outcome.out.startswith("Usage: sdaeverify")


def test_help_lists_all_exit_codes(call):
    """The meanings of the exit codes are part of the help."""
    text = " ".join(call("matrix", "-h").out.split())

    assert all(f"{code.value} {code.words}" in text for code in ExitCode)


def test_dry_run(call, tmp_path):
    """A dry run shows every cell, its view or why it cannot be run, and writes nothing."""
    outcome = call(
        *("matrix", "--dry-run", "-j", "1", "-s", "euler-maruyama,half-explicit-euler", "-p", "gbm,pendulum"),
        *("-m", "strong,drift", "--out", "x"),
    )

    lines = [line.split(maxsplit=4) for line in outcome.out.splitlines()[2:-1]]
    assert (outcome.code, outcome.err) == (0, "")
    assert ["run", "euler-maruyama", "pendulum", "drift", "inherent SDE"] in [list(map(str.strip, x)) for x in lines]
    assert [line[:4] for line in lines if line[0] == "run"] == [
        ["run", "euler-maruyama", "gbm", "strong"],
        ["run", "euler-maruyama", "pendulum", "drift"],
        ["run", "euler-maruyama", "pendulum", "strong"],
        ["run", "half-explicit-euler", "pendulum", "drift"],
        ["run", "half-explicit-euler", "pendulum", "strong"],
    ]
    assert "does not apply  half-explicit-euler  gbm       strong   needs a HolonomicSDAE" in outcome.out
    assert "5 of 8 cells would be run" in outcome.out
    assert not list(tmp_path.iterdir())


def test_a_dry_run_starts_no_worker(call, monkeypatch):
    """Schemes and problems are asked in the process itself."""
    monkeypatch.setattr(Processes, "submit", None)
    assert call("matrix", "--dry-run", "-s", "milstein", "-p", "gbm", "-j", "2").code == 0


def test_dry_run_of_nothing(call):
    """A dry run that finds nothing to run says so by its exit code."""
    assert call("matrix", "--dry-run", "-s", "half-explicit-euler", "-p", "gbm", "-j", "1").code == 5


def test_what_is_shown_and_written(quick):
    """Plain text of 80 columns that ends with the exit code in words; tables, page and evidence."""
    outcome = quick("-p", "gbm,pendulum", "-s", "half-explicit-euler", "-m", "strong,drift", "--out", "out")

    assert (outcome.code, outcome.err) == (0, "")
    assert "\x1b" not in outcome.out
    assert max(map(len, outcome.out.splitlines())) <= 80
    assert re.match(r"\d+ quantities: \d+ verified, none refuted", outcome.out)
    assert "verdicts.csv, levels.csv, columns.csv" in outcome.out
    assert outcome.out.endswith("exit code 0: no claim is refuted, and no check fails\n")
    tables = {"verdicts.csv", "not_applicable.csv", "levels.csv", "columns.csv", "details"}
    written = {*tables, "run.json", "report.html", "evidence"}
    assert written == {path.name for path in Path("out").iterdir() if path.suffix != ".parquet"}


def test_words_of_the_command_line_are_kept(quick):
    """The report says by which command it was made."""
    quick("-p", "gbm", "-s", "milstein", "--seed", "7")
    run = json.loads(Path("reports/latest/run.json").read_text())

    assert run["arguments"][:2] == ["sdaeverify", "matrix"]
    assert run["arguments"][-6:] == ["-p", "gbm", "-s", "milstein", "--seed", "7"]
    assert run["seed"] == 7


@pytest.mark.long
def test_plain_progress(call):
    """Where stderr is no terminal, each finished cell is one line."""
    budget = ("--paths", "40", "--levels", "3", "-j", "1")

    outcome = call("matrix", *budget, "-s", "euler-maruyama", "-p", "gbm,pendulum", "-m", "strong,drift")

    cells = [line.split("  ")[:3] for line in outcome.err.splitlines()]
    assert cells == [
        ["euler-maruyama", "gbm", "strong"],
        ["euler-maruyama", "pendulum", "drift"],
        ["euler-maruyama", "pendulum", "strong"],
    ]
    assert re.search(r"  pendulum  drift  \d \w+(, \d \w+)*  \d+\.\d\d s\n", outcome.err)


@pytest.mark.long
def test_bar_on_a_terminal(call, monkeypatch):
    """A terminal shows a bar with the problem, the share that is done and the time that is left, and colours."""
    monkeypatch.setenv("FORCE_COLOR", "1")

    outcome = call("matrix", "--paths", "40", "--levels", "3", "-j", "1", "-p", "gbm", "-s", "milstein")

    assert "gbm" in outcome.err
    assert re.search(r"100%.*0:00:\d\d.*0:00:00", outcome.err)
    assert "milstein  gbm" not in outcome.err
    assert re.search(r"\x1b\[33m\? inconclusive: milstein on gbm", outcome.out)


@pytest.mark.long
def test_colours_can_be_switched_off(quick, monkeypatch):
    """NO_COLOR is respected on a terminal too."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("NO_COLOR", "1")

    assert not re.search(r"\x1b\[[0-9;]*3\d", quick("-p", "gbm", "-s", "milstein").out)


@pytest.mark.long
def test_plugins_are_warned_about(quick, monkeypatch):
    """What is odd about the environment is one warning each."""
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", "nobody")

    outcome = quick("-p", "gbm", "-s", "milstein")

    assert outcome.code == 0
    assert outcome.err.splitlines() == [
        "sdaeverify: warning: SDAEVERIFY_DISABLED_PLUGINS names 'nobody', which is no plugin"
    ]


@pytest.mark.long
def test_broken_installed_plugin(quick, tmp_path, monkeypatch):
    """An installed plugin that is broken costs a warning, not the run; the list of plugins gives the reason."""
    information = tmp_path / "site" / "fake_dist-2.5.dist-info"
    information.mkdir(parents=True)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: fake-dist\nVersion: 2.5\n")
    (information / "entry_points.txt").write_text("[sdaeverify]\nfake = no_such_module\n")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))

    outcome = quick("-p", "gbm", "-s", "milstein")

    assert outcome.code == 0
    assert outcome.err.startswith("sdaeverify: warning: plugin fake (fake-dist 2.5) is broken and left out: ")
    assert len(outcome.err.splitlines()) == 1


@pytest.mark.long
def test_report_hooks(quick, write):
    """A plugin may write beside the report; if it fails, that is a warning."""
    hooks = "@hookimpl\ndef sdaeverify_report(folder):\n    (folder / 'mine.txt').write_text('x')\n    1 / 0\n"

    outcome = quick("-p", "gbm", "-s", "milstein", "--plugin", write(hooks), "--out", "out")

    assert outcome.code == 0
    why = "ZeroDivisionError: division by zero (odd_plugin.py:10)"
    assert outcome.err == f"sdaeverify: warning: report of plugin odd_plugin: {why}\n"
    assert Path("out/mine.txt").exists()


@pytest.mark.long
def test_one_scheme_alone(quick):
    """A scheme that runs alone gets the same rows as among others, bit by bit."""
    others = ("-s", "euler-maruyama,half-explicit-*,milstein")
    quick("--out", "all", *others, "-p", "gbm,pendulum", "-m", "strong,weak")
    quick("--out", "alone", "-s", "half-explicit-euler[truncation=none]", "-p", "pendulum", "-m", "strong")

    for name in ("verdicts.csv", "levels.csv", "details/strong.csv"):
        alone = rows("alone", name)
        wanted = [(row["scheme"], row["problem"], row["measure"], row["quantity"]) for row in alone]
        among = {(r["scheme"], r["problem"], r["measure"], r["quantity"], r.get("h")): r for r in rows("all", name)}
        assert len(wanted) >= 8
        for row in alone:
            other = among[row["scheme"], row["problem"], row["measure"], row["quantity"], row.get("h")]
            assert {key: other[key] for key in row} == row


@pytest.mark.long
def test_reproduce(call, odd_scheme):
    """The command of a row computes that row again, with its plugin, seed and block."""
    plugin = odd_scheme(
        "B = problem.diffusion(t, state); "
        "return Step(state + h * problem.drift(t, state) + np.einsum('dlp,lp->dp', B + 0 * noise.dW, noise.dW))"
    )
    budget = ("--paths", "100", "--seed", "5", "--block", "64", "--confidence", "0.9")
    budget = (*budget, "--levels", "4..64", "--first-levels", "4")
    call("matrix", "-s", "odd", "-p", "gbm[b=0.25]", "--plugin", plugin, *budget, "-j", "1")
    (row, *_) = before = rows("reports/latest")

    command = shlex.split(command_of(row, json.loads(Path("reports/latest/run.json").read_text())))
    outcome = call(*command[3:], "-j", "1")

    assert command[:3] == ["python", "-m", "sdaeverify"]
    assert outcome.code == 0
    again, same = rows("reports/reproduced"), [other for other in before if other["measure"] == row["measure"]]
    # Columns that only other measures fill are not there again.
    assert again == [{key: other[key] for key in again[0]} for other in same]
    assert rows("reports/latest") == before


def test_a_command_that_computes_a_cell_again_is_understood(call):
    """Whatever the settings of a run are, its command is one that matrix takes."""
    settings = Settings(
        paths=80, levels=4, first_levels=3, seed=1, confidence=0.9, block=80, max_looks=2, tests_reserved=7
    )
    _, _, *words = shlex.split(reproduce(("milstein", "gbm", "strong"), settings))

    assert call(*words[1:], "--dry-run", "-j", "1").code == 0
