"""What a worker process is held to, and how it marks whose code runs."""

import os
import pickle
import subprocess
import sys
import time
from math import inf

import pytest

from facade import FAULTS, NO_MEASURE, NOBODY, PROBLEM, Limits, Mark, Marker, StopError, Watchdog, read_mark
from sdaeverify import UsageError


@pytest.fixture
def mark(tmp_path):
    """Return the place of a mark."""
    return tmp_path / "mark"


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan")])
def test_no_time(timeout):
    """A limit that leaves no time is refused."""
    with pytest.raises(UsageError, match="timeout must be a positive number of seconds"):
        Limits(timeout)


def test_a_marker_sets_no_limits():
    """Without limits nothing is marked, and errors pass."""
    with pytest.raises(KeyError), Marker().of(0), Marker().measure(1):
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
        assert read_mark(mark).scheme == PROBLEM
    assert read_mark(mark).scheme == NOBODY


@pytest.mark.parametrize("kind", [KeyboardInterrupt, BaseException])
def test_what_ends_a_program_is_a_fault_of_who_raises_it(mark, kind):
    """In a worker it is not the user's: it becomes an error that says so, between processes too."""
    dog = Watchdog(mark, inf)

    with pytest.raises(FAULTS) as found, dog.of(3):
        raise kind
    with pytest.raises(StopError, match=kind.__name__), dog.of(3), dog.measure(1):
        raise kind

    sent = pickle.loads(pickle.dumps(found.value))
    assert str(sent) == f"{kind.__name__}: raised by the plugin"
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


def test_time_is_counted_for_each_scheme(mark):
    """What one scheme has used up is used up for it, and for no other."""
    dog = Watchdog(mark, 100.0)
    with dog.of(0):
        time.sleep(0.2)

    before = time.monotonic()
    with dog.of(1):
        assert read_mark(mark).deadline >= before + 100.0
    with dog.of(0):
        assert read_mark(mark).deadline <= time.monotonic() + 99.8


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_copy_does_not_come_back(mark):
    """A step that forks comes back once, from the process that it was called in; its copy ends quietly."""
    for marker in (Marker(), Watchdog(mark, inf)):
        with marker.of(0):
            child = os.fork()
        if not child:
            os._exit(0)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1


MEMORY = """
from sdaeverify.workers.limits import limited_memory

for limit, size in ((2**28, 2**27), (0, 2**29), (2**28, 2**29)):
    with limited_memory(limit):
        print(len(bytearray(size)))
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the address space is not limited in this way")
def test_memory():
    """A process may have as much more as it is given, and no more than that; 0 is no limit."""
    outcome = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True, check=False)

    assert outcome.stdout == f"{2**27}\n{2**29}\n"
    assert "MemoryError" in outcome.stderr


def test_platforms_without_limits(monkeypatch):
    """Where there is none of memory, asking for it is an error that says what to leave out."""
    monkeypatch.setattr("sdaeverify.workers.limits.resource", None)

    assert Limits() == Limits(inf, 0)
    with pytest.raises(UsageError, match="leave out --memory"):
        Limits(memory=1)
