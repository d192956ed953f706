"""The program as a process where the system has no room for it, or a plugin hangs: one line, a code, nobody left."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

pytestmark = pytest.mark.long

PROGRAM = (sys.executable, "-m", "sdaeverify")
SMALL = ("-s", "milstein", "-p", "gbm", "-m", "strong", "--paths", "80", "--progress", "none", "-j", "2")
PATIENCE = 120.0
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="/proc and limits of address space are Linux's")
# What a full /dev/shm is to Python.
FULL = """
import _multiprocessing, os, sys
from sdaeverify import hookimpl

class SemLock(_multiprocessing.SemLock):
    def __new__(cls, *given, **named):
        raise OSError(28, os.strerror(28))

_multiprocessing.SemLock = SemLock

@hookimpl
def sdaeverify_schemes():
    return []
"""
HANGING = """
import re
from pathlib import Path
Path(__file__).with_suffix(".begun").touch()
# Neither signals of Python nor other threads are heard of meanwhile.
re.match("(a*)*b", "a" * 100)
"""


def one_line_of(words, folder, **options):
    """Return the exit code of the program, and the only line that it has written."""
    ended = subprocess.run(
        [*PROGRAM, *words], cwd=folder, capture_output=True, text=True, check=False, timeout=PATIENCE, **options
    )
    (line,) = (ended.stdout + ended.stderr).splitlines()
    return ended.returncode, line


def limit(kibibytes):
    """Return a function that limits the address space of a process, as ``ulimit -v`` does."""

    def before_start():
        import resource  # noqa: PLC0415 - not on every platform

        resource.setrlimit(resource.RLIMIT_AS, (kibibytes << 10, kibibytes << 10))

    return before_start


@LINUX
def test_address_space(tmp_path):
    """Where there is too little the program says at once how much it needs; with that much a run comes to its end."""
    for kibibytes in (250_000, 550_000):
        code, line = one_line_of(("matrix", *SMALL), tmp_path, preexec_fn=limit(kibibytes))
        told = f"sdaeverify: error: a process may have {kibibytes >> 10} MiB of address space (ulimit -v)"
        assert (code, line[: len(told)]) == (3, told)
    needed = int(line.rpartition(" MiB: raise the limit")[0].rpartition(" ")[2])

    ended = subprocess.run(
        [*PROGRAM, "matrix", *SMALL, "-q"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
        preexec_fn=limit(needed << 10),
    )

    assert (ended.returncode, ended.stderr) == (0, "")


@LINUX
def test_no_room_for_semaphores(tmp_path):
    """A full /dev/shm is no defect of the program, and is named."""
    (tmp_path / "full.py").write_text(FULL)

    code, line = one_line_of(("matrix", *SMALL, "--plugin", "full.py"), tmp_path)

    assert code == 3
    begun = "sdaeverify: error: worker processes cannot be started: OSError: [Errno 28] No space left on device"
    assert line.startswith(begun)
    assert line.endswith("; is /dev/shm full?")


def alive(mark):
    """Return the processes that have a word in their command line."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if mark.encode() in (folder / "cmdline").read_bytes():
                found.append(int(folder.name))
    return found


def wait_until(condition):
    """Wait for a condition, for as long as is patient, and tell whether it came."""
    end = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    return condition()


@LINUX
def test_a_plugin_that_hangs_as_it_is_loaded(tmp_path):
    """The program ends by a signal, and none of its processes goes on for a plugin that nobody waits for."""
    plugin = tmp_path / "hanging.py"
    plugin.write_text(HANGING)
    process = subprocess.Popen([*PROGRAM, "list", "--plugin", str(plugin)], stderr=subprocess.DEVNULL)
    try:
        assert wait_until(plugin.with_suffix(".begun").exists)
        process.terminate()

        assert process.wait(PATIENCE) == -signal.SIGTERM
        assert wait_until(lambda: not alive(str(plugin)))
    finally:
        for left in alive(str(plugin)):
            os.kill(left, signal.SIGKILL)


LOUD = """
import os, sys
from typing import ClassVar
from sdaeverify import SDE, Claim, Scheme, Step, hookimpl

print("while it is loaded" * 10_000)

class Loud(Scheme):
    name: ClassVar[str] = "loud"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        print("in a step" * 10_000)
        print("as an error" * 10_000, file=sys.stderr)
        return Step(problem.euler(t, state, h, noise))

@hookimpl
def sdaeverify_schemes():
    return [Loud()]
"""


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize("alone", [("-j", "1", "--timeout", "0", "--memory", "0"), ("-j", "2")])
def test_what_plugins_print_is_cut(tmp_path, alone):
    """A scheme that prints in each of its steps fills no disk: a megabyte is kept, and it is said that it was cut."""
    (tmp_path / "loud.py").write_text(LOUD)
    budget = ("--paths", "80", "--levels", "8..32", "--progress", "none", "-q")
    words = ("matrix", "-s", "loud", "-p", "gbm", "-m", "strong", *budget)
    with (tmp_path / "err").open("w") as file:
        ended = subprocess.run(
            [*PROGRAM, *words, *alone, "--plugin", "loud.py"],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=file,
            text=True,
            check=False,
            timeout=PATIENCE,
        )

    told = (tmp_path / "err").read_text()
    assert ended.returncode == 0
    assert "in a step" not in ended.stdout
    assert "in a step" in told
    assert "what plugins print is cut here" in told
    assert len(told) < 3.5 * 2**20
