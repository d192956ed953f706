"""What the code of plugins prints is no result: it goes to stderr, even what is written past Python."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from facade import execute
from sdaeverify.cli.console import output_to_stderr

pytestmark = pytest.mark.long

CHATTY = """
import os, sys
from typing import ClassVar
from sdaeverify import SDE, Claim, Scheme, Step, hookimpl

def say(where):
    print("printed in", where)
    print("printed by force in", where, file=sys.__stdout__)
    os.write(1, f"written in {where}\\n".encode())

say("import")

class Chatty(Scheme):
    name: ClassVar[str] = "zz-chatty"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def refuses(self, problem):
        say("question")
        return ""

    def step(self, problem, state, t, h, noise):
        say("step")
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

@hookimpl
def sdaeverify_schemes():
    say("hook")
    return [Chatty()]

def zz_told() -> SDE:
    say("problem")
    return SDE(drift=lambda t, x: -x, diffusion=lambda t, x: x[:, None], start=[1.0], noise_dim=1, horizon=1.0,
               source="nowhere")

@hookimpl
def sdaeverify_problems():
    return [zz_told]

@hookimpl
def sdaeverify_report(folder):
    say("report")
"""
PROGRAM = (sys.executable, "-m", "sdaeverify")
BUDGET = ("--paths", "80", "--block", "40", "--levels", "8..32", "-j", "1")
# No worker process beside the program.
ALONE = ("-j", "1", "--timeout", "0", "--memory", "0")


@pytest.fixture
def program(tmp_path, monkeypatch, capfd):
    """Run a command line in this process with a plugin that prints wherever it is called."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "chatty.py").write_text(CHATTY)

    def run(*words):
        execute([*words, "--plugin", "chatty.py"])
        return capfd.readouterr()

    yield run
    for name in [name for name in sys.modules if name.startswith("sdaeverify_file_")]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("words", "where"),
    [
        (("check", "zz-chatty", "zz-told", "-p", "gbm", "--json"), ("import", "hook", "problem", "step")),
        (("list", "--json"), ("import", "hook")),
    ],
    ids=["check", "list"],
)
def test_json_is_readable(program, words, where):
    """Whatever the plugin prints, and how, JSON is all there is on stdout."""
    out, err = program(*words)

    assert json.loads(out)
    for place in where:
        for how in ("printed in", "printed by force in", "written in"):
            assert f"{how} {place}" in err


@pytest.mark.parametrize(
    ("words", "places"),
    [
        (("info", "zz-told"), ("problem",)),
        (("matrix", "-s", "zz-chatty", "-p", "gbm", "-m", "strong", *BUDGET, *ALONE), ("question", "step", "report")),
        (("matrix", "-s", "zz-chatty", "-p", "gbm", "--dry-run", *ALONE), ("question",)),
    ],
    ids=["info", "matrix", "dry run"],
)
def test_tables_are_not_interrupted(program, words, places):
    """What is shown to people has nothing of the plugin between its lines."""
    out, err = program(*words)

    assert out.strip()
    assert not [line for line in out.splitlines() if line.startswith(("printed", "written"))]
    for place in places:
        assert f"written in {place}" in err


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX")
@pytest.mark.parametrize("redirected", [">&-", ">&- 2>&-"])
def test_streams_that_are_closed(redirected):
    """Without stdout or stderr the program ends as it does with them."""
    words = " ".join([*PROGRAM, "list", "--json", redirected])

    ended = subprocess.run(["bash", "-o", "pipefail", "-c", words], capture_output=True, text=True, check=False)

    assert ended.returncode == 0
    assert "Traceback" not in ended.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize("words", ["--version", "list --json"])
def test_a_full_disk_is_one_line(words):
    """A result that cannot be written is no defect, whether it fails while it is printed or at the end."""
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [*PROGRAM, *words.split()], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )

    told = "cannot write the output: No space left on device; make room, or send it elsewhere"
    assert (ended.returncode, ended.stderr) == (3, f"sdaeverify: error: {told}\n")


def test_stdout_is_back_afterwards(capfd):
    """An error in the code of the plugin leaves stdout where it was."""

    def broken():
        os.write(1, b"aside\n")
        raise KeyError

    with pytest.raises(KeyError), output_to_stderr():
        broken()
    os.write(1, b"result\n")

    assert capfd.readouterr() == ("result\n", "aside\n")


def test_a_stream_without_a_file(capsys):
    """Where stdout is no file, as in a notebook, what is printed goes to stderr all the same."""
    with output_to_stderr():
        print("aside")
    print("result")

    assert capsys.readouterr() == ("result\n", "aside\n")
