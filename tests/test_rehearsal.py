"""What might end the process, done in a copy of it first."""

import os
import sys
import threading
import time

import pytest

from sdaeverify.registry.rehearsal import rehearse

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")


def test_what_comes_back():
    """What is harmless says nothing, changes nothing and shows nothing; nor does an ordinary error."""
    done = []

    assert rehearse(lambda: done.append(print("shown"))) == ""
    assert rehearse(lambda: 1 / 0) == ""
    assert rehearse(sys.exit) == ""
    assert done == []


def test_what_is_printed_is_not_shown(capfd):
    """It will be shown when it is done in earnest, and what was waiting to be shown comes out once."""
    sys.stdout.write("before")

    rehearse(lambda: print("during", flush=True))

    assert capfd.readouterr() == ("before", "")


@pytest.mark.parametrize(
    ("deed", "words"),
    [
        (lambda: os._exit(0), "ends the process with status 0"),
        (lambda: os._exit(7), "ends the process with status 7"),
        (os.abort, "ends the process by SIGABRT"),
        (lambda: exec("raise KeyboardInterrupt"), "raises KeyboardInterrupt: no message"),
        (lambda: time.sleep(300.0), "does not come back within 0.2 s"),
        # A copy of the copy holds what it would have told by.
        (lambda: (os.fork() and os._exit(3)) or time.sleep(300.0), "ends the process with status 3"),
    ],
    ids=["exits", "fails", "aborts", "interrupts", "hangs", "forks"],
)
def test_what_does_not(deed, words):
    """What would have become of the process is said, within the time there is."""
    begun = time.monotonic()

    assert rehearse(deed, 0.2 if "0.2" in words else 200.0).partition(" (")[0] == words

    assert time.monotonic() - begun < 200.0


def test_a_long_message_of_any_letters():
    """However long its message is, and whatever is in it, an error is told."""

    class Stop(BaseException):
        pass

    def deed():
        raise Stop("\udc80\n" * 100_000)

    assert rehearse(deed).startswith("raises Stop: ?")


def test_beside_other_threads():
    """A process with other threads is copied without a word."""
    over = threading.Event()
    thread = threading.Thread(target=over.wait)
    thread.start()
    try:
        assert rehearse(lambda: os._exit(1)) == "ends the process with status 1"
    finally:
        over.set()
        thread.join()
