"""The program as a process: interrupts, dead workers, closed pipes, any number of workers."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from evidence import rows_of
from facade import conclude

from .conftest import HEADER, SCHEME

pytestmark = pytest.mark.long

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
def interruptible() -> Iterator[None]:
    """Hear interrupts: whom a shell starts in the background ignores them, and so do all that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def start(tmp_path: Path, interruptible: None) -> Iterator[Start]:
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
    """Return the verdicts of a report, without what corrects for the number of tests of the run."""
    left = {"p_family", "family", "p_adjusted"}
    found = rows_of(folder / "verdicts.csv")
    return [{name: text for name, text in row.items() if name not in left} for row in found]


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
    # One of the workers hangs. The other one judges what is finished: a single one would judge it after five minutes.
    process = start("matrix", *chosen, "-j", "2", "--timeout", "300")
    wait_for(process, "milstein  gbm")

    process.kill()
    process.communicate(timeout=PATIENCE)

    verdict = {row["problem"]: row["verdict"] for row in verdicts(tmp_path / "reports" / "latest") if row["claim"]}
    assert verdict["gbm"] in {"verified", "inconclusive"}


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
    """Nobody reading on is no error, and does not change what a check came to."""
    process = start("check", "odd", "-p", "gbm", "--plugin", odd_scheme("raise ValueError"))
    process.stdout.close()

    assert process.stderr.read() == ""
    assert process.wait(timeout=PATIENCE) == 1


def test_any_number_of_workers_whatever_becomes_of_them(call, odd_scheme, tmp_path):
    """In two workers rows are those of this process, bit by bit; one that dies costs those of its own scheme."""
    chosen = ("-p", "pendulum", "-m", "strong,drift", *BUDGET, "--progress", "none")
    dying = ("--plugin", odd_scheme("os._exit(0)"))
    assert call("matrix", "-s", SCHEMES, *chosen, "-j", "1", "--out", "1").err == ""

    outcome = call("matrix", "-s", f"{SCHEMES},odd", *chosen, "-j", "2", "--out", "2", *dying)

    assert outcome.code == 3
    assert "its worker process died with exit code 0, twice" in " ".join(outcome.out.split())
    one, two = (verdicts(tmp_path / folder) for folder in "12")
    assert {row["verdict"] for row in two if row["scheme"] == "odd"} == {"error"}
    assert [row for row in two if row["scheme"] != "odd"] == one
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


CONSOLE_SCRIPT = """
import sys
from sdaeverify.cli.main import run
if __name__ == "__main__":
    sys.exit(run())
"""
SPLIT = """
from {package} import Odd
from sdaeverify import hookimpl
@hookimpl
def sdaeverify_schemes():
    return [Odd()]
"""


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize("program", ["script", "module"])
def test_modules_of_the_current_folder_and_beside_a_plugin_are_found(tmp_path: Path, program: str) -> None:
    """The console script finds what ``python -m`` does, in its workers too, which unpickle the schemes."""
    script = tmp_path / "bin" / "sdaeverify"
    script.parent.mkdir()
    script.write_text(CONSOLE_SCRIPT)
    code = HEADER + GATED[: GATED.index("@hookimpl")]
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
    (tmp_path / "here" / "__init__.py").write_text(code)
    (tmp_path / "there" / "neighbour.py").write_text(code.replace('"odd"', '"other"'))
    (tmp_path / "mine.py").write_text(SPLIT.format(package="here"))
    (tmp_path / "there" / "mine.py").write_text(SPLIT.format(package="neighbour"))

    command = (sys.executable, str(script)) if program == "script" else PROGRAM
    words = ["matrix", "--plugin", "mine.py", "--plugin", "there/mine.py", "-s", "odd,other", "-p", "gbm", *STRONG]
    ended = subprocess.run(
        [*command, *words, *BUDGET, "-j", "2", "--no-html"], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert ended.returncode in (0, 1), ended.stderr
    assert all(name in ended.stdout for name in ("odd", "other"))
