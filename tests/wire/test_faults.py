"""Programs with a fault: one line that says what is wrong, within the time they have, and none stays behind."""

import os
import signal
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from facade import gbm
from sdaeverify import Increment, SchemeError
from sdaeverify_wire.scheme import scheme_of, session_of
from wire import faulty
from wire.test_processes import ENDED, MARK, marked, wait_for

FAULTY = Path(faulty.__file__)
# Of programs that are silent on purpose; others are given more, on a machine that is busy with other tests.
SHORT, PATIENCE = 0.8, 120.0
# What the line says.
AT_HELLO = {
    "silent": "has not answered for 0.8 s",
    "ends": "ended with exit code 3",
    "ends without a word": "ended with exit code 0",
    "dies": "ended with signal 9",
    "other version": "speaks version 2 of the wire, expected 1",
    "other version in words": "expected the line 'hello version=1'",
    "big-endian": "its numbers are big-endian, expected little-endian float64",
    "unknown word": "said 'language C' as its hello, expected one of name, form,",
    "no name": "said no name in its hello",
    "unknown form": "said form 'PDE' in its hello, expected one or more of SDE,",
    "name twice": "said name twice",
    "bad claim": "said 'claim strong' in its hello, expected claim MEASURE VALUE",
    "unknown trait": "sunny",
    "unknown ask": "said that it asks 'weather'; of SDE it may ask constraint,",
    "bytes in place of text": "printable letters",
    "line without end": "bytes without end of line: b'aaa",
    "lines without end": "sent 200 lines without a hello",
    "half a number": "ended with exit code 0 with 4 of 8 bytes missing",
    "words on stderr": "ended with exit code 4; its stderr ends: first line | cannot find licence",
    "closes its stdout": "closed its stdout",
}
IN_STEP = {
    "a row too many": "sent 'done x=2x3', expected 'x=1x3' first",
    "a path too few": "sent 'done x=1x2', expected 'x=1x3' first",
    "paths first": "sent 'done x=3x1', expected 'x=1x3' first",
    "another name": "sent 'done y=1x3', expected 'x=1x3' first",
    "no state": "sent 'done ', expected 'x=1x3' first",
    "flags first": "sent 'done failed=3', expected 'x=1x3' first",
    "unknown array": "sent 'error' behind the state, expected failed, truncated, output.NAME or cost.NAME",
    "state twice": "sent x twice",
    "flags of another shape": "sent failed of shape 1x3, expected 3",
    "flags that are no flags": "sent failed with numbers other than 0 and 1",
    "cost of another shape": "sent cost.n of shape 4, expected 3",
    "ends in an array": "ended with exit code 0 with 14 of 24 bytes missing",
    "dies in an array": "ended with signal 9 with 14 of 24 bytes missing",
    "stops in an array": "has not answered for 0.8 s",
    "single precision": "has not answered for 0.8 s",
    "more than its answer": "sent b'more' after its answer",
    "answers twice": "after its answer",
    "no shape": "sent 'x=axb' in the line",
    "negative shape": "sent 'x=-1x3' in the line",
    "five axes": "sent 'x=1x1x1x1x3' in the line",
    "more than there is": "announces x of shape 9999999999x9999999999, more than",
    "another word": "sent 'finished', expected ask, done or error",
    "carriage return": "printable letters",
    "long line": "of at most 4096 printable letters",
    "asks what it did not say": "asks 'diffusion', which its hello does not name behind 'asks'",
    "asks nothing there is": "asks 'weather', which its hello does not name behind 'asks'",
    "asks without a name": "asks 't=1', which its hello does not name",
    "asks with rows too many": "asks drift with 't=1 x=2x3', expected 't=1 x=1x3'",
    "asks without a time": "asks drift with 'x=1x3', expected 't=1 x=1x3'",
    "asks in another order": "asks drift with 'x=1x3 t=1', expected 't=1 x=1x3'",
    "asks too much": "announces x of shape 1x9999999999, more than",
    "asks and ends": "ended with exit code 5",
    "asks half and stops": "has not answered for 0.8 s",
    "error": "says: no root within 50 iterations",
    "says hello again": "sent",
    "silent in a step": "has not answered for 0.8 s",
    "dies in a step": "ended with signal 9",
    "floods": "after its answer",
}
# Each of these waits in the same place as another one, until its time is over.
WAITS_LIKE_OTHERS = {"stops in an array", "single precision", "asks half and stops"}


def waiting_late(faults, late):
    """Return faults as parameters; those that wait like others are long."""
    return [pytest.param(fault, marks=pytest.mark.long) if fault in late else fault for fault in faults]


def command(fault=""):
    """Return the command of the program with a fault, which starts in a few milliseconds."""
    return [sys.executable, "-I", "-S", str(FAULTY), *([fault] if fault else [])]


def patience_of(line):
    """Return the time for a program whose fault is told by a line."""
    return SHORT if "has not" in line else PATIENCE


def made(scheme, paths=3):
    """Make two steps on gbm and return the state; what comes behind the first answer is there before the second."""
    problem, dW = gbm(), np.zeros((1, paths))
    x = problem.initial(paths)
    for t in (0.0, 0.5):
        x = scheme.step(problem, x, t, 0.5, Increment(dW, None)).state
        time.sleep(0.02)
    return x


def children():
    """Return the processes that this one has started and that still run."""
    return Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split()


def check_line(error, fault, begun):
    """Assert that an error is one line about the program, and came in time."""
    text = str(error.value)
    assert text.startswith("python")
    assert "\n" not in text
    assert len(text) < 600
    assert "Traceback" not in text
    assert time.monotonic() - begun < PATIENCE


@pytest.mark.sweep
@pytest.mark.parametrize("fault", AT_HELLO)
def test_fault_at_hello_is_one_line(fault):
    """A program that says no proper hello is not registered: one line says why."""
    begun, before = time.monotonic(), children()

    with pytest.raises(SchemeError) as error:
        scheme_of(command(fault), patience_of(AT_HELLO[fault]))

    check_line(error, fault, begun)
    assert AT_HELLO[fault] in str(error.value)
    assert set(children()) <= set(before)


@pytest.mark.sweep
@pytest.mark.parametrize("fault", waiting_late(IN_STEP, WAITS_LIKE_OTHERS))
def test_fault_in_a_step_is_one_line(fault):
    """A program that breaks off, stops or answers something else costs one line, and is ended."""
    scheme, before = scheme_of(command(fault), patience_of(IN_STEP[fault])), children()
    begun = time.monotonic()

    with pytest.raises(SchemeError) as error:
        made(scheme)

    check_line(error, fault, begun)
    assert IN_STEP[fault] in str(error.value)
    assert set(children()) <= set(before)


def test_every_fault_has_its_line():
    """Each fault of the program is either expected above, or one that is no error of the wire."""
    harmless = {"flood on stderr", "not a number", "stdin is never read"}
    assert {*faulty.AT_HELLO, *faulty.IN_STEP} == {*AT_HELLO, *IN_STEP, *harmless}


def test_program_that_does_not_read_is_ended():
    """A request that fills the pipe waits no longer than the program's time."""
    scheme = scheme_of(command("stdin is never read"), SHORT)

    with pytest.raises(SchemeError, match=r"has not read its request for 0\.8 s"):
        made(scheme, paths=10**5)


@pytest.mark.parametrize("fault", ["", "flood on stderr"])
def test_what_is_no_fault_passes(fault):
    """Without a fault, and with more words on stderr than a pipe holds, the state comes back."""
    scheme = scheme_of(command(fault), PATIENCE)

    np.testing.assert_array_equal(made(scheme), gbm().initial(3))
    session_of(scheme.calling).drop()


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="processes are found in /proc")
def test_script_is_ended_with_what_it_has_started(monkeypatch):
    """A program behind a shell script that keeps it, and another one in the background, end as the script does."""
    mark = f"{os.getpid()}-script"
    monkeypatch.setenv(MARK, mark)
    script = 'sleep 299 & "$0" "$@"; true'
    scheme = scheme_of(["/bin/sh", "-c", script, *command("silent in a step")], SHORT)

    with pytest.raises(SchemeError, match=r"has not answered for 0\.8 s"):
        made(scheme)
    assert wait_for(lambda: not marked(mark), ENDED), marked(mark)


def test_nan_is_a_state_like_any_other():
    """What is not finite is told by the framework, as of any scheme."""
    scheme = scheme_of(command("not a number"), PATIENCE)

    assert np.isnan(made(scheme)).all()
    session_of(scheme.calling).drop()


def test_program_that_was_ended_between_steps_is_started_again():
    """What has ended without a request fails no step."""
    scheme = scheme_of(command(), PATIENCE)
    before = children()
    made(scheme)
    [program] = set(children()) - set(before)
    os.kill(int(program), signal.SIGKILL)
    time.sleep(0.1)

    np.testing.assert_array_equal(made(scheme), gbm().initial(3))
    [other] = set(children()) - set(before)
    assert other != program
    session_of(scheme.calling).drop()


def test_program_that_has_died_is_started_again(tmp_path):
    """The step in which it dies fails, the next one does not."""
    mark = tmp_path / "died"
    text = FAULTY.read_text().replace(
        "IN_STEP.get(FAULT, done)(*message)",
        f"(done if os.path.exists({str(mark)!r}) else lambda *_: (os.mkdir({str(mark)!r}), die()))(*message)",
    )
    (tmp_path / "once.py").write_text(text)
    scheme = scheme_of([sys.executable, "-I", "-S", str(tmp_path / "once.py")], PATIENCE)

    with pytest.raises(SchemeError, match="ended with signal 9"):
        made(scheme)
    np.testing.assert_array_equal(made(scheme), gbm().initial(3))
    session_of(scheme.calling).drop()
