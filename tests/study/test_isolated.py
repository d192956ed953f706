"""An executor whose workers die alone."""

import os
import sys
import time
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from multiprocessing import active_children, get_context

import pytest

from sdaeverify.workers.isolated import Died, Isolated
from sdaeverify.workers.limits import Limits
from sdaeverify.workers.pool import worker_pool
from sdaeverify.workers.room import NoWorkersError

PATIENCE = 200.0


class Pool(Executor):
    """A pool of one process that is none: it dies of a call that says so, or of nothing at all."""

    def __init__(self):
        self.calls, self.broken, self.ended = [], False, False

    def submit(self, call):
        if self.broken:
            raise BrokenExecutor("it died before")
        future = Future()
        self.calls.append((call, future))
        return future

    def shutdown(self, wait=True, *, cancel_futures=False):
        self.ended = True

    def work(self):
        """Make the call that waits."""
        call, future = self.calls.pop()
        try:
            future.set_result(call())
        except BrokenExecutor as error:
            self.broken = True
            future.set_exception(error)
        except ValueError as error:
            future.set_exception(error)


@pytest.fixture
def pools():
    """Return the pools that were made."""
    return []


@pytest.fixture
def isolated(pools, tmp_path):
    """Return an executor of two workers."""

    def make():
        pools.append(Pool())
        return pools[-1]

    return Isolated(make, 2, Limits(), tmp_path)


def die():
    raise BrokenExecutor("exit code 9")


def fail():
    raise ValueError("wrong")


def test_workers_are_made_as_they_are_needed(isolated, pools):
    """One call needs one worker; a third one waits for the first of two that is free."""
    first = isolated.submit(int, 1)
    assert len(pools) == 1
    second, third = isolated.submit(int, 2), isolated.submit(int, 3)
    assert (len(pools), [len(pool.calls) for pool in pools]) == (2, [1, 1])

    pools[0].work()
    pools[0].work()
    pools[1].work()

    assert [future.result(0) for future in (first, second, third)] == [1, 2, 3]


def test_a_worker_that_dies_takes_its_own_call(isolated, pools):
    """The other calls are made, in a new worker where the old one was needed."""
    lost, kept, waiting = isolated.submit(die), isolated.submit(int, 2), isolated.submit(int, 3)

    before = time.monotonic()
    pools[0].work()
    pools[1].work()
    pools[2].work()

    with pytest.raises(Died, match="exit code 9") as death:
        lost.result(0)
    assert before <= death.value.when <= time.monotonic()
    assert (kept.result(0), waiting.result(0)) == (2, 3)
    assert pools[0].ended


def test_a_worker_that_died_while_idle_is_replaced(isolated, pools):
    """A call is made in a new worker if the old one is gone when it comes."""
    isolated.submit(int, 1)
    pools[0].work()
    pools[0].broken = True

    later = isolated.submit(int, 2)
    pools[1].work()

    assert later.result(0) == 2


def test_a_worker_that_cannot_be_made(tmp_path):
    """Who waits for a call hears of it, also where the call waited for its turn."""
    made = []

    def make():
        if made:
            raise OSError("no more processes")
        made.append(Pool())
        return made[0]

    isolated = Isolated(make, 1, Limits(), tmp_path)
    first, second = isolated.submit(die), isolated.submit(int, 2)
    made[0].work()

    assert isinstance(first.exception(0), Died)
    assert isinstance(second.exception(0), NoWorkersError)
    assert "cannot be started: OSError: no more processes" in str(second.exception(0))


def test_what_a_call_raises_is_raised(isolated, pools):
    """An error of a call is its result; the worker lives on."""
    failed = isolated.submit(fail)
    pools[0].work()
    isolated.submit(int, 1)

    with pytest.raises(ValueError, match="wrong"):
        failed.result(0)
    assert len(pools) == 1


def test_afresh(isolated, pools):
    """A call that asks for it is made in a process in which nothing was called before; the old one ends."""
    isolated.submit(int, 1)
    pools[0].work()

    future = isolated.submit_afresh(int, 2)
    assert (len(pools), pools[0].ended) == (2, True)
    pools[1].work()

    assert future.result(0) == 2


def test_the_end(isolated, pools):
    """Calls that wait can be given up, and all workers are ended."""
    isolated.submit(int, 1)
    isolated.submit(int, 2)
    waiting = isolated.submit(int, 3)

    isolated.shutdown(cancel_futures=True)

    with pytest.raises(CancelledError):
        waiting.result(0)
    assert all(pool.ended for pool in pools)


@pytest.mark.skipif(sys.platform == "win32", reason="what is left of a process is a matter of POSIX")
def test_real_processes(tmp_path):
    """A process that dies when it has nothing to do is replaced, and none is left in the end."""
    isolated = Isolated(lambda: ProcessPoolExecutor(1, mp_context=get_context("spawn")), 1, Limits(), tmp_path)

    isolated.submit(time.sleep, 0.0).result(PATIENCE)
    (worker,) = active_children()
    worker.kill()
    worker.join()
    until = time.monotonic() + PATIENCE
    while not isolated._pools[0]._broken and time.monotonic() < until:
        time.sleep(0.01)
    assert isolated.submit(pow, 2, 2).result(PATIENCE) == 4
    with pytest.raises(Died):
        isolated.submit(os._exit, 0).result(PATIENCE)
    assert isolated.submit(pow, 2, 3).result(PATIENCE) == 8
    isolated.shutdown()

    assert not active_children()


def test_workers_end_where_the_block_is_left_by_an_error():
    """Whatever they are doing, they are ended at once."""
    begun = time.monotonic()

    def leave():
        with worker_pool(2) as pool:
            pool.submit(pow, 2, 3).result(PATIENCE)
            pool.submit(time.sleep, 300.0)
            raise KeyError

    with pytest.raises(KeyError):
        leave()

    assert time.monotonic() - begun < PATIENCE
    assert not active_children()


def test_workers_are_started_before_there_are_calls(isolated, pools):
    """As many as are asked for and there are; the first call goes to one of them."""
    isolated.start(5)
    assert [len(pool.calls) for pool in pools] == [1, 1]

    for pool in pools:
        pool.work()
    future = isolated.submit(int, "7")
    next(pool for pool in pools if pool.calls).work()

    assert future.result() == 7
    assert len(pools) == 2
