"""Calls over an executor, their results in turn."""

from concurrent.futures import Executor, Future
from functools import partial

import pytest

from facade import Limits, Processes, executor_for, in_turn


class Backwards(Executor):
    """Makes calls only when a result is asked for, and notes how many wait."""

    def __init__(self):
        self.waiting, self.most = 0, 0

    def submit(self, call):
        self.waiting += 1
        self.most = max(self.most, self.waiting)
        return Late(self, call)


class Late(Future):
    def __init__(self, executor, call):
        super().__init__()
        self.executor, self.call = executor, call

    def result(self, timeout=None):
        self.executor.waiting -= 1
        return self.call()


def calls(count):
    return ((key, partial(pow, key, 2)) for key in range(count))


@pytest.mark.parametrize("window", [1, 3, 100])
def test_results_in_turn(window):
    """Results come in the order of the calls, and no more calls than the window are in flight."""
    executor = Backwards()

    assert list(in_turn(executor, window, calls(10))) == [(key, key**2) for key in range(10)]
    assert executor.most == min(window, 10)


def test_no_executor():
    """Without an executor each call is made as its result is asked for."""
    made = []
    results = in_turn(None, 1, ((key, partial(made.append, key)) for key in range(3)))

    next(results)

    assert made == [0]


@pytest.mark.parametrize(
    ("jobs", "limits", "kind"),
    [(0, None, type(None)), (1, None, type(None)), (2, None, Processes), (1, Limits(memory=2**30), Processes)],
)
def test_processes_only_where_they_are_needed(jobs, limits, kind):
    """One job runs in this process unless it is held to limits."""
    with executor_for(jobs, (), limits) as executor:
        assert type(executor) is kind


@pytest.mark.long
def test_modules_that_register(tmp_path, monkeypatch):
    """A worker imports the modules of plugins: one that registers a scheme may set what another module defines."""
    (tmp_path / "somebodys_scheme.py").write_text("weight = 1.0")
    (tmp_path / "somebodys_plugin.py").write_text("import somebodys_scheme\nsomebodys_scheme.weight = 2.0")
    monkeypatch.syspath_prepend(str(tmp_path))

    with executor_for(1, limits=Limits(), modules=["somebodys_plugin"]) as executor:
        assert executor.submit(eval, "__import__('somebodys_scheme').weight").result() == 2.0
