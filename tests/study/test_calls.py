"""Calls in workers that die."""

from concurrent.futures import Future

import pytest

from sdaeverify.errors import UsageError
from sdaeverify.simulate.marker import NO_MEASURE
from sdaeverify.workers.calls import DIED, Call, Lost, pickle_argument, unpickle_argument
from sdaeverify.workers.isolated import Died, Isolated
from sdaeverify.workers.limits import FORMAT, Limits, Mark

WHEN = 100.0


class Mortal(Isolated):
    """Its processes die of calls one after another, with a mark or, as if they had not begun, without one."""

    def __init__(self, folder, deaths):
        super().__init__(None, 1, Limits(5.0), folder)
        self.deaths, self.calls = list(deaths), []

    def submit(self, fn, /, *args):
        """Make a call in any process."""
        self.calls.append("any")
        return self._outcome(fn, *args)

    def submit_afresh(self, fn, /, *args):
        """Make a call in a new process."""
        self.calls.append("new")
        return self._outcome(fn, *args)

    def _outcome(self, fn, argument, mark, timeout):
        future = Future()
        if not self.deaths:
            future.set_result(fn(argument, mark, timeout))
            return future
        left = self.deaths.pop(0)
        if left is not None:
            mark.write_bytes(FORMAT.pack(*left))
        future.set_exception(Died("it died", WHEN))
        return future


def called(argument, mark, timeout):
    """Return what a call is given, and leave a mark."""
    mark.write_bytes(FORMAT.pack(*Mark()))
    return argument, timeout


def made(folder, *deaths, **options):
    """Return a call whose processes die in turn, and the processes it asked for."""
    executor = Mortal(folder, deaths)
    return Call(executor, called, b"x", **options), executor.calls


def test_a_call_that_nothing_happens_to(tmp_path):
    """It returns what the function returns, and leaves no mark."""
    call, calls = made(tmp_path)

    assert call.outcome() == (b"x", 5.0)
    assert (calls, call.fresh) == (["any"], False)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("deadline", "why"),
    [(WHEN, "late by 5 s"), (WHEN + 1.0, f"{DIED}, perhaps for want of memory")],
    ids=["late", "dead"],
)
def test_a_process_that_dies_of_a_call(tmp_path, deadline, why):
    """The mark tells whose code ran and whether it was the alarm; nothing is tried again here."""
    mark = Mark(2, NO_MEASURE, deadline)
    call, calls = made(tmp_path, mark)

    lost = call.outcome()

    assert lost == Lost(mark, deadline == WHEN, 5.0)
    assert lost.why("late by {:g} s") == why
    assert calls == ["any"]
    assert not list(tmp_path.iterdir())


def test_a_process_that_dies_before_a_call(tmp_path):
    """The call is made again in a new process, and says so."""
    call, calls = made(tmp_path, None)

    assert call.outcome() == (b"x", 5.0)
    assert (calls, call.fresh) == (["any", "new"], True)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fresh", [False, True])
def test_a_new_process_that_dies_without_a_mark(tmp_path, fresh):
    """In a new process there was nothing else to die of: it is the call, and nobody in particular."""
    call, calls = made(tmp_path, None, None, fresh=fresh)

    assert call.outcome() == Lost(Mark(), False, 5.0)
    assert calls == (["new"] if fresh else ["any", "new"])


def test_no_two_calls_share_a_mark(tmp_path):
    """Calls of an executor never touch the marks of others."""
    executor = Isolated(None, 1, Limits(), tmp_path)

    assert executor.new_mark() != executor.new_mark()


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
    with pytest.raises(UsageError, match="a plugin file was saved while the run was under way; run it again"):
        unpickle_argument(b"csdaeverify_file_odd_0123456789\nOdd\n.")
