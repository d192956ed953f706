"""Programs end with whoever has started them: a worker, or the whole run, however that one ends."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from wire import faulty

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="processes are found in /proc"),
    pytest.mark.skipif(shutil.which("setpriv") is None, reason="without setpriv a program hears of no killed parent"),
]
MARK = "SDAEVERIFY_TEST_OF_THE_WIRE"
# Seconds after which a run that has started no program never will, and a process that has not ended never does: on a
# machine that is busy with other work, each takes many times as long as alone.
STARTED, ENDED = 120.0, 120.0


def marked(value):
    """Return the processes that have inherited a mark, with their command lines."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={value}\0".encode() in (folder / "environ").read_bytes():
                found[int(folder.name)] = (folder / "cmdline").read_bytes().decode().replace("\0", " ")
        except OSError:
            continue
    return found


def wait_for(condition, seconds):
    """Wait until something is true, and return whether it is."""
    until = time.monotonic() + seconds
    while not condition() and time.monotonic() < until:
        time.sleep(0.05)
    return condition()


def programs(mark):
    """Return the programs of a marked run."""
    return [pid for pid, command in marked(mark).items() if "faulty.py" in command]


@pytest.fixture
def begun(tmp_path, request):
    """Return a run whose program hangs in a step, in a busy loop that hears of nothing, and its mark."""
    source = Path(faulty.__file__).read_text()
    busy = source.replace(
        '"silent in a step": lambda s, f: time.sleep(600)', '"silent in a step": lambda s, f: spin()'
    )
    busy = busy.replace("def main():", "def spin():\n    while True:\n        pass\n\n\ndef main():")
    (tmp_path / "faulty.py").write_text(busy)
    command = [sys.executable, "-I", "-S", str(tmp_path / "faulty.py"), "silent in a step"]
    (tmp_path / "p.py").write_text(
        f"from sdaeverify_wire import schemes\nsdaeverify_schemes = schemes({command!r}, patience=300)\n"
    )
    mark = f"{os.getpid()}-{request.node.name}"
    given = ["matrix", "--plugin", "p.py", "-s", "faulty", "-p", "gbm", "--progress", "none", *request.param]
    process = subprocess.Popen(
        [sys.executable, "-m", "sdaeverify", *given],
        cwd=tmp_path,
        env={**os.environ, MARK: mark},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    # The first one says hello to the registry, and ends: that of a worker begins to spin.
    assert wait_for(lambda: any(seconds_of(pid) > 0.3 for pid in programs(mark)), STARTED), marked(mark)
    yield process, mark
    process.kill()
    process.wait()


def seconds_of(pid):
    """Return the processor time of a process; 0 of one that has ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.parametrize("begun", [("-j", "2"), ("-j", "1", "--timeout", "0", "--memory", "0")], indirect=True)
@pytest.mark.parametrize("signal_number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_killed_run_leaves_no_process(begun, signal_number):
    """A run that is killed takes its workers and their programs with it, whatever they do."""
    process, mark = begun
    process.send_signal(signal_number)

    assert wait_for(lambda: not programs(mark), ENDED), marked(mark)
    process.wait(ENDED)
    assert wait_for(lambda: not marked(mark), ENDED), marked(mark)


@pytest.mark.parametrize("begun", [("-j", "1", "--timeout", "2")], indirect=True)
def test_program_ends_with_its_time(begun):
    """A program that takes longer than a scheme may is ended with its worker, and the run comes to its end."""
    process, mark = begun

    assert process.wait(120) == 3
    assert wait_for(lambda: not marked(mark), ENDED), marked(mark)


@pytest.mark.parametrize(
    "begun",
    [
        (
            "-j",
            "1",
        )
    ],
    indirect=True,
)
def test_killed_worker_leaves_no_program(begun):
    """A worker that is killed takes its program with it."""
    process, mark = begun
    [program] = [pid for pid in programs(mark) if seconds_of(pid) > 0.3]
    worker = int(Path(f"/proc/{program}/stat").read_text().rpartition(")")[2].split()[1])
    os.kill(worker, signal.SIGKILL)

    assert wait_for(lambda: program not in programs(mark), ENDED), marked(mark)
    assert process.poll() is None
