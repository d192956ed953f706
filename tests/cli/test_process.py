"""The program as a process: interrupts, dead workers, closed pipes, any number of workers."""

import csv
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from facade import conclude

from .conftest import SCHEME

PROGRAM = (sys.executable, "-m", "sdaeverify")
BUDGET = ("--paths", "80", "--block", "40", "--levels", "8..32")
# Far longer than any of these tests may take, on a block of paths.
# With a truth, which nobody asks whether it is one, its paths are as short as those of gbm and come after them.
SLOW = """SDE(
    drift=lambda t, x: (time.sleep(300.0) if x.shape[-1] == 40 else None, x)[1],
    diffusion=lambda t, x: x[:, None], start=[1.0], noise_dim=1, horizon=1.0, source="nowhere",
    truths=[Pathwise(start=lambda n: np.ones((1, n)), advance=lambda x, t, h, noise: x, parts=lambda t, x: {"x": x},
    source="nowhere")])"""
PATIENCE = 200.0
STRONG = ("-m", "strong")
# No worker process beside the program.
ALONE = ("-j", "1", "--timeout", "0", "--memory", "0")
SCHEMES = "milstein,half-explicit-euler[truncation=none]"

POLICY = """
[tool.sdaeverify]
plugins = ["odd_plugin.py"]
problems = ["gbm"]
tier = "smoke"
"""
GATED = SCHEME.format(step="return Step(state + h * problem.drift(t, state))")

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start the program in a session of its own; end what is left of it."""
    running: list[subprocess.Popen[str]] = []

    def launch(*arguments: str) -> "subprocess.Popen[str]":
        pipe = subprocess.PIPE
        process = subprocess.Popen(
            [*PROGRAM, *arguments], cwd=tmp_path, stdout=pipe, stderr=pipe, text=True, start_new_session=True
        )
        running.append(process)
        return process

    yield launch
    for process in running:
        process.kill()
        process.communicate()


def wait_for(process: "subprocess.Popen[str]", beginning: str) -> None:
    """Read stderr up to a line with this beginning."""
    line = next(line for line in process.stderr if line.startswith(beginning))
    assert line


def verdicts(folder: Path) -> list[dict[str, str]]:
    """Return the verdicts of a report."""
    with (folder / "verdicts.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def signal_group(process: "subprocess.Popen[str]", number: int) -> None:
    """Send a signal to a process and all its children."""
    os.killpg(process.pid, number)


@pytest.mark.skipif(sys.platform == "win32", reason="signals to a group of processes are a matter of POSIX")
def test_interrupt(start, odd_problem, tmp_path):
    """An interrupt of the whole group ends everything at once, in one line that counts what can be run."""
    plugin = odd_problem(SLOW)
    process = start(
        "matrix", "-s", "milstein", "-p", "delay-ou,gbm,zz-odd", *STRONG, "--plugin", plugin, *BUDGET, "-j", "2"
    )
    wait_for(process, "milstein  gbm")

    # As a terminal does it; the pipes end when all processes that hold them have ended.
    signal_group(process, signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)

    assert (process.returncode, out) == (130, "")
    assert err == "sdaeverify: interrupted; 1 of 2 problems are finished and saved in reports/latest\n"
    rows = verdicts(tmp_path / "reports" / "latest")
    assert {row["verdict"] for row in rows if row["problem"] == "gbm"} <= {
        "verified",
        "inconclusive",
    }
    left = [row for row in rows if row["problem"] == "zz-odd" and row["measure"] == "strong"]
    assert [(row["verdict"], row["reason"]) for row in left] == [("not_run", "interrupted")]


@pytest.mark.skipif(sys.platform == "win32", reason="signals to a group of processes are a matter of POSIX")
def test_workers_end_with_a_killed_parent(start, odd_problem, tmp_path):
    """A program that is killed leaves no workers behind, and what was finished is on disk."""
    plugin = odd_problem(SLOW)
    chosen = ("-s", "milstein", "-p", "gbm,zz-odd", *STRONG, "--plugin", plugin, *BUDGET)
    # One worker, which hangs: a limit of time is what gives one job a process of its own.
    process = start("matrix", *chosen, "-j", "1", "--timeout", "300")
    wait_for(process, "milstein  gbm")

    process.kill()
    process.communicate(timeout=PATIENCE)

    verdict = {row["problem"]: row["verdict"] for row in verdicts(tmp_path / "reports" / "latest") if row["claim"]}
    assert verdict["gbm"] in {"verified", "inconclusive"}


def test_dead_worker(call, odd_scheme, tmp_path):
    """A worker that dies costs the rows of the scheme whose code ran, and no others."""
    plugin = odd_scheme("os._exit(0)")

    outcome = call("matrix", "-s", "odd,milstein", "-p", "gbm", *STRONG, "--plugin", plugin, *BUDGET, "-j", "2")

    assert outcome.code == 3
    told = " ".join(outcome.out.split())
    assert (
        "in error: odd on gbm, strong: order >= 1.0 (margin 0.2); its worker process died with exit code 0, twice"
        in told
    )
    rows = verdicts(tmp_path / "reports" / "latest")
    assert {row["verdict"] for row in rows if row["scheme"] == "odd"} == {"error"}
    assert "error" not in {row["verdict"] for row in rows if row["scheme"] == "milstein"}


LEAVING = """
@hookimpl
def sdaeverify_report(folder):
    {leave}
"""


@pytest.mark.parametrize(
    ("leave", "words"),
    [
        ("os._exit(0)", ""),
        pytest.param(
            "raise type('Leaving', (BaseException,), {})",
            "error: a plugin raised Leaving: no message",
            marks=pytest.mark.slow,
        ),
    ],
    ids=["exits", "raises"],
)
def test_a_gate_that_was_ended_early_has_left_no_outcome(start, write, tmp_path, leave, words):
    """Its file is written last: who asks for it takes no early end of the process for a green gate."""
    write(GATED + LEAVING.format(leave=leave))
    (tmp_path / "pyproject.toml").write_text(POLICY)

    process = start("gate", "--progress", "none", *ALONE)
    _, err = process.communicate(timeout=PATIENCE)

    assert words in err
    assert not (tmp_path / "reports" / "gate" / "gate.json").is_file()


def test_closed_pipe(start, odd_scheme):
    """Nobody reading on is no error, and does not change what a run came to."""
    chosen = ("-s", "odd", "-p", "gbm", *STRONG, *BUDGET, *ALONE, "--progress", "none")
    process = start("matrix", *chosen, "--plugin", odd_scheme("raise ValueError"))
    process.stdout.close()

    assert process.stderr.read() == ""
    assert process.wait(timeout=PATIENCE) == 3


def test_any_number_of_workers(call, tmp_path):
    """The program by itself and two workers give the same rows, bit by bit."""
    for jobs in ("1", "2"):
        chosen = ("-p", "gbm,pendulum", "-s", SCHEMES, "-m", "strong,drift", *BUDGET)
        assert call("matrix", *chosen, "-j", jobs, "--out", jobs, "--progress", "none").err == ""

    assert verdicts(tmp_path / "1") == verdicts(tmp_path / "2")
    assert (tmp_path / "1" / "levels.csv").read_text() == (tmp_path / "2" / "levels.csv").read_text()


def test_console_script_and_module_are_the_same():
    """The console script calls what ``python -m`` calls."""
    assert entry_points(group="console_scripts")["sdaeverify"].value == "sdaeverify.cli.main:run"


def test_defect_of_the_program(capsys, monkeypatch):
    """What nobody expected keeps its traceback, and does not end like a refuted claim."""
    monkeypatch.setattr("sdaeverify.cli.program.execute", lambda _: 1 / 0)

    assert conclude([]) == 3

    err = capsys.readouterr().err
    assert "ZeroDivisionError" in err
    assert err.endswith("sdaeverify: error: this is a defect of sdaeverify; please report it with the lines above\n")
