"""What a worker process is held to, and how it marks whose code runs."""

import pickle
import signal
import subprocess
import sys
import time
from math import inf

import pytest

from sdaeverify.errors import FAULTS, UsageError
from sdaeverify.guard import NO_MEASURE, PROBLEM, Guard
from sdaeverify.study.limits import ALARM_SLACK, NOBODY, Limits, Mark, StopError, Watchdog, read_mark

POSIX = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="alarms are a matter of POSIX")
BEGIN = "import os, sys, time\nfrom pathlib import Path\nfrom sdaeverify.study.limits import Watchdog, limit_memory\n"
PATIENCE = 60.0


@pytest.fixture
def mark(tmp_path):
    """Return the place of a mark."""
    return tmp_path / "mark"


def ended(text, *arguments):
    """Run a program in a process of its own and return how it ended."""
    words = [sys.executable, "-c", BEGIN + text, *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, check=False)


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan")])
def test_no_time(timeout):
    """A limit that leaves no time is refused."""
    with pytest.raises(UsageError, match="timeout must be a positive number of seconds"):
        Limits(timeout)


def test_a_guard_watches_nobody():
    """Without limits nothing is marked, and errors pass."""
    with pytest.raises(KeyError), Guard().of(0), Guard().measure(1):
        raise KeyError


def test_whose_code_runs_is_marked(mark):
    """A mark in a file tells scheme, measure and problem as they run, and nobody else."""
    dog = Watchdog(mark, inf)

    assert read_mark(mark) == Mark()
    with dog.of(3):
        assert read_mark(mark)[:2] == (3, NO_MEASURE)
        with dog.measure(1):
            assert read_mark(mark)[:2] == (3, 1)
        assert read_mark(mark)[:2] == (3, NO_MEASURE)
    with dog.of(PROBLEM):
        assert read_mark(mark).lane == PROBLEM
    assert read_mark(mark).lane == NOBODY


def test_a_mark_survives_an_error(mark):
    """What raises in code that is watched leaves no mark of it."""
    dog = Watchdog(mark, inf)

    with pytest.raises(KeyError), dog.of(3), dog.measure(1):
        raise KeyError

    assert read_mark(mark) == Mark()


@pytest.mark.parametrize("kind", [KeyboardInterrupt, BaseException])
def test_what_ends_a_program_is_a_fault_of_who_raises_it(mark, kind):
    """In a worker it is not the user's: it becomes an error that says whose code raised it, between processes too."""
    dog = Watchdog(mark, inf)

    with pytest.raises(FAULTS) as found, dog.of(3):
        raise kind
    with pytest.raises(StopError, match=kind.__name__), dog.of(3), dog.measure(1):
        raise kind

    sent = pickle.loads(pickle.dumps(found.value))
    assert (str(sent), sent.lane) == (f"{kind.__name__}: raised by the plugin", 3)
    assert read_mark(mark) == Mark()


@pytest.mark.parametrize("kind", [KeyError, SystemExit, GeneratorExit])
def test_other_errors_pass_as_they_are(mark, kind):
    """What costs a row its result anyway is told by its own name."""
    with pytest.raises(kind), Watchdog(mark, inf).of(3):
        raise kind


@pytest.mark.parametrize("content", [b"", b"short", b"x" * 100])
def test_a_mark_that_is_none(mark, content):
    """A file that is no mark blames nobody."""
    mark.write_bytes(content)

    assert read_mark(mark) == Mark()


@POSIX
def test_the_alarm_is_off_between_times(mark):
    """No alarm goes off while nobody's code runs, and none is left by an error."""
    dog = Watchdog(mark, 100.0)

    with dog.of(0):
        assert 0.0 < signal.getitimer(signal.ITIMER_REAL)[0] <= 100.0
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0
    with pytest.raises(KeyError), dog.of(0):
        raise KeyError
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


@POSIX
def test_time_is_counted_for_each_scheme(mark):
    """What one scheme has used up is used up for it, and for no other."""
    dog = Watchdog(mark, 100.0)
    with dog.of(0):
        time.sleep(0.2)

    with dog.of(0):
        first = read_mark(mark).deadline - time.monotonic()
    with dog.of(1):
        second = read_mark(mark).deadline - time.monotonic()

    assert first <= 99.8 < second <= 100.0


def test_what_ended_a_process():
    """It was the alarm if it died when that was due, however late that is found out."""
    mark = Mark(0, NO_MEASURE, 100.0)

    assert not mark.timed_out(99.0)
    assert mark.timed_out(100.0 - ALARM_SLACK / 2)
    assert mark.timed_out(100.1)
    assert not Mark().timed_out(1e12)


@POSIX
@pytest.mark.parametrize(
    "code", ["time.sleep(60)", "\n        while True: pass", "sum(range(10**12))"], ids=["sleeps", "spins", "in C"]
)
def test_code_that_never_comes_back_is_ended(mark, code):
    """The alarm ends a process whatever it does, and leaves the mark of who did it."""
    begun = time.monotonic()

    outcome = ended(f"dog = Watchdog(Path(sys.argv[1]), 0.3)\nwith dog.of(5):\n    with dog.measure(2): {code}", mark)

    assert outcome.returncode == -signal.SIGALRM
    assert outcome.stderr == ""
    assert read_mark(mark)[:2] == (5, 2)
    assert begun < read_mark(mark).deadline < time.monotonic()


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the address space is not limited in this way")
def test_memory():
    """A process may have as much more as it is given, and no more than that."""
    take = "limit_memory(2**28)\nx = bytearray(int(sys.argv[1]))\nprint(len(x))"

    within, beyond = ended(take, 2**27), ended(take, 2**29)

    assert (within.returncode, within.stdout) == (0, f"{2**27}\n")
    assert "MemoryError" in beyond.stderr


def test_memory_without_limit():
    """0 is no limit."""
    assert ended("limit_memory(0)\nprint(len(bytearray(2**28)))").stdout == f"{2**28}\n"


def test_platforms_without_limits(monkeypatch):
    """Where there are none, asking for one is an error that says what to leave out."""
    monkeypatch.setattr("sdaeverify.study.limits._has_resource", lambda: False)
    monkeypatch.delattr(signal, "setitimer", raising=False)

    assert Limits() == Limits(inf, 0)
    with pytest.raises(UsageError, match="leave out --timeout"):
        Limits(timeout=1.0)
    with pytest.raises(UsageError, match="leave out --memory"):
        Limits(memory=1)


def test_a_mark_costs_little(mark):
    """Marking is cheap beside a step: some microseconds, with the alarm."""
    dog, begun = Watchdog(mark, 100.0 if hasattr(signal, "setitimer") else inf), time.process_time()

    for _ in range(1000):
        with dog.of(0):
            pass

    assert time.process_time() - begun < 0.5
