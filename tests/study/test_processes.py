"""Worker processes of this machine: one that dies or takes too long takes its own call with it, and none is left."""

import os
import pickle
import signal
import sys
import time
from multiprocessing import active_children
from pathlib import Path

import pytest

from facade import DIED, Call, Limits, Lost, Processes, pickle_argument, unpickle_argument
from sdaeverify import UsageError
from sdaeverify.workers.room import NoWorkersError

pytestmark = pytest.mark.long

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="processes that fork are a matter of POSIX")
PATIENCE = 200.0


def ends(argument, marker):
    """End the process in a way that is asked for, perhaps with a copy left that holds its pipes."""
    kind, number, file = argument
    with marker.of(3):
        if kind == "kill":
            os.kill(os.getpid(), number)
        if kind == "exit" and (child := os.fork()):
            Path(file).write_text(str(child))
            os._exit(number)
        if kind == "exit":
            time.sleep(300.0)
    return number


def hangs(file, marker):
    """Do all that there is against being ended, and write down what lives on."""
    signal.signal(signal.SIGALRM, signal.SIG_IGN)
    with marker.of(3):
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        if child := os.fork():
            Path(file).write_text(str(child))
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


def has_ended(process):
    """Wait until a process is dead: a signal that nobody can ignore takes a moment all the same."""
    until = time.monotonic() + PATIENCE
    while is_alive(process) and time.monotonic() < until:
        time.sleep(0.01)
    return not is_alive(process)


def refuse(*_):
    """Start no thread."""
    raise RuntimeError("can't start new thread")


@POSIX
def test_who_dies_takes_its_own_call(tmp_path):
    """The exit code or the signal is told, and whose code ran; the calls beside it and after it are made."""
    file = tmp_path / "child"
    asked = [("exit", 0), ("none", 1), ("kill", 11), ("kill", 9)]
    with Processes(2, limits=Limits(PATIENCE)) as pool:
        calls = [Call(pool, ends, pickle.dumps((*each, file))) for each in asked]
        found = [call.outcome() for call in calls]

    told = [each.why if isinstance(each, Lost) else each for each in found]
    killed = [f"{DIED} of SIGSEGV", f"{DIED} of SIGKILL, possibly out of memory"]
    assert told == [f"{DIED} with exit code 0", 1, *killed]
    assert {each.mark.scheme for each in found if isinstance(each, Lost)} == {3}
    assert not active_children()
    assert has_ended(int(file.read_text()))


@POSIX
def test_who_hangs_is_ended_with_its_copies(tmp_path):
    """A call that ignores alarms is lost within its time, and whoever waits for one behind it ends it."""
    file = tmp_path / "child"
    with Processes(1, limits=Limits(1.0)) as pool:
        first = Call(pool, hangs, pickle.dumps(str(file)))
        assert Call(pool, ends, pickle.dumps(("none", 2, file))).outcome() == 2
        lost = first.outcome()

    assert (lost.mark.scheme, lost.late) == (3, True)
    assert has_ended(int(file.read_text()))


@POSIX
def test_workers_are_started_as_they_are_needed():
    """No more than there are calls, and a new one for who asks for it, or in place of one that died between calls."""
    with Processes(8) as pool:
        pool.expect(1)
        first = pool.submit(os.getpid).result(PATIENCE)
        with pool.afresh() as fresh:
            assert fresh.submit(os.getpid).result(PATIENCE) != first
        (worker,) = active_children()
        assert pool.submit(os.getpid).result(PATIENCE) == first == worker.pid
        os.kill(first, signal.SIGKILL)
        worker.join()
        assert Call(pool, ends, pickle.dumps(("none", 2, ""))).outcome() == 2


@POSIX
def test_workers_end_where_the_block_is_left(monkeypatch):
    """By an error, too: neither what they do nor threads of pebble that never end keep them alive."""
    monkeypatch.setattr("sdaeverify.workers.pool.ENDING", 0.1)

    def leave():
        with Processes(1, limits=Limits(PATIENCE)) as pool:
            found.append(pool.submit(os.getpid).result(PATIENCE))
            pool.submit(time.sleep, 300.0)
            monkeypatch.setattr(pool._pool, "join", lambda: time.sleep(PATIENCE))
            raise KeyError

    found, begun = [], time.monotonic()
    with pytest.raises(KeyError):
        leave()

    assert has_ended(*found)
    assert time.monotonic() - begun < PATIENCE


def test_a_pool_that_cannot_be_made(monkeypatch):
    """What the system refuses as a pool is made is told as that, with what may help."""
    with Processes(1) as pool:
        monkeypatch.setattr("threading.Thread.start", refuse)
        with pytest.raises(NoWorkersError, match=r"^worker processes cannot be started: .*new thread.*; try fewer"):
            pool.submit(os.getpid)


class Unreadable:
    """What cannot be read where it is sent to."""

    def __init__(self, error):
        self.error = error

    def __reduce__(self):
        return raising, (self.error,)


def raising(error):
    """Raise an error."""
    raise error("no such thing")


def test_what_cannot_be_read():
    """It is told in one line what to do, except for errors that the caller knows better about."""
    told = r"cannot be read in a worker process: MemoryError: no such thing .*; define it at the top level of a mod"
    with pytest.raises(UsageError, match=told):
        unpickle_argument(pickle_argument(Unreadable(MemoryError), "it"))
    with pytest.raises(MemoryError):
        unpickle_argument(pickle_argument(Unreadable(MemoryError), "it"), MemoryError)
    with pytest.raises(UsageError, match="cannot be read in a worker process: KeyError"):
        unpickle_argument(pickle_argument(Unreadable(KeyError), "it"), MemoryError)


def test_what_cannot_be_sent():
    """It is told in one line who is to blame."""
    with pytest.raises(UsageError, match=r"^scheme x cannot be sent to worker processes: .*top level of a module"):
        pickle_argument(lambda: None, "scheme x")
    assert unpickle_argument(pickle_argument((1, "a"), "scheme x")) == (1, "a")


def test_a_plugin_file_that_was_saved_meanwhile():
    """A worker that has loaded another version of a plugin file says so, and not that something is badly defined."""
    with pytest.raises(UsageError, match="a plugin file changed during the run; run it again"):
        unpickle_argument(b"csdaeverify_file_odd_0123456789\nOdd\n.")
