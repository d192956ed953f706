"""Workers that take too long are ended from outside."""

import os
import signal
import sys
import time
from math import inf
from pathlib import Path

import pytest

from sdaeverify.simulate.marker import NO_MEASURE
from sdaeverify.workers.calls import Call, Lost
from sdaeverify.workers.isolated import Died, Turn
from sdaeverify.workers.limits import FORMAT, Limits, Mark, Watchdog
from sdaeverify.workers.pool import BEGINNING, deadline, worker_pool
from sdaeverify.workers.room import NoWorkersError

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="processes that fork are a matter of POSIX")
PATIENCE = 200.0


def hangs(argument, mark, timeout):
    """Do all that there is against being ended, and write down what lives on."""
    signal.signal(signal.SIGALRM, signal.SIG_IGN)
    with Watchdog(mark, timeout).of(3):
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        if child := os.fork():
            Path(argument.decode()).write_text(str(child))
        time.sleep(300.0)


def dies(argument, mark, timeout):
    """Die, and leave behind what holds the pipes of the process."""
    with Watchdog(mark, timeout).of(3):
        if child := os.fork():
            Path(argument.decode()).write_text(str(child))
            os._exit(0)
        time.sleep(300.0)


def is_alive(process):
    """Tell whether a process runs; one that is dead and not buried by its new parent does not."""
    status = Path(f"/proc/{process}/stat")
    if status.parent.parent.joinpath("self").exists():
        return status.is_file() and status.read_text().rpartition(")")[2].split()[0] not in "ZX"
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def refuse(*_):
    """Start no thread."""
    raise RuntimeError("can't start new thread")


@POSIX
@pytest.mark.parametrize(("call", "limit", "late"), [(hangs, 2.0, True), (dies, PATIENCE, False)])
def test_no_way_out(tmp_path, call, limit, late):
    """A call that ignores alarms, or dies with a copy of itself left, is lost within its time, and the copy ends."""
    file = tmp_path / "child"
    with worker_pool(1, limits=Limits(limit)) as pool:
        begun = time.monotonic()
        lost = Call(pool, call, str(file).encode()).outcome()

    child, until = int(file.read_text()), time.monotonic() + PATIENCE
    assert isinstance(lost, Lost)
    assert (lost.mark.lane, lost.late) == (3, late)
    assert time.monotonic() - begun < PATIENCE
    while is_alive(child) and time.monotonic() < until:
        time.sleep(0.01)
    assert not is_alive(child)


def test_deadlines(tmp_path):
    """A worker may be busy until its mark says so, without a mark for a while, and where it needs none for ever."""
    mark = tmp_path / "mark"

    assert deadline(Turn(100.0, None), 5.0) == inf
    assert deadline(Turn(100.0, mark), 5.0) == 105.0 + BEGINNING
    assert deadline(Turn(100.0, mark), inf) == inf
    mark.write_bytes(FORMAT.pack(*Mark(0, NO_MEASURE, 7.0)))
    assert deadline(Turn(100.0, mark), 5.0) == 7.0
    mark.write_bytes(FORMAT.pack(*Mark()))
    assert deadline(Turn(100.0, mark), 5.0) == inf


@POSIX
@pytest.mark.slow
def test_a_call_that_never_begins(tmp_path, monkeypatch):
    """A worker that hangs before it comes to its call is late as well."""
    monkeypatch.setattr("sdaeverify.workers.pool.BEGINNING", 8.0)
    plugin = tmp_path / "plugin.py"
    plugin.write_text("while True: pass")

    with worker_pool(1, [str(plugin)], Limits(0.5)) as pool:
        lost = Call(pool, hangs, b"").outcome()

    assert lost == Lost(Mark(), True, 0.5)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_pool_whose_manager_has_died(monkeypatch):
    """Where a thread of a pool cannot be started, who waits for its result is told, and does not wait for ever."""
    monkeypatch.setattr("multiprocessing.queues.Queue._start_thread", refuse)
    with worker_pool(1) as pool, pytest.raises(Died, match="the thread that manages its worker has died"):
        pool.submit(os.getpid).result(PATIENCE)


def test_a_pool_that_cannot_be_made(monkeypatch):
    """What the system refuses as a pool is made is told as that, with what may help."""
    with worker_pool(1) as pool:
        monkeypatch.setattr("threading.Thread.start", refuse)
        with pytest.raises(NoWorkersError, match=r"^worker processes cannot be started: .*new thread.*; try fewer"):
            pool.submit(os.getpid).result(PATIENCE)
