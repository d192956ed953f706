"""Ends workers that take too long, from outside: nothing that their code does to signals and alarms helps it."""

import os
import threading
import time
from math import inf
from multiprocessing.process import BaseProcess

from .isolated import Isolated, Turn, end_process
from .limits import read_mark

# How often the marks of workers are read.
PERIOD = 0.05
# What a process may take beside its time until it begins with a call: to start, to load plugins, to read the call.
BEGINNING = 60.0


class Timekeeper:
    """A thread that reads the marks of busy workers and ends those whose time is over.

    A worker that is dead while something it has started lives on, and holds its pipes, is buried, too: whoever waits
    for its result would not hear of its death.

    Parameters
    ----------
    pool : Isolated
    """

    def __init__(self, pool: Isolated) -> None:
        self._pool, self._over = pool, threading.Event()
        self._thread = threading.Thread(target=self._watch, name="sdaeverify-timekeeper", daemon=True)

    def __enter__(self) -> "Timekeeper":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        while not self._over.wait(PERIOD):
            for worker, turn in self._pool.turns().items():
                self.look(worker, turn)

    def look(self, worker: int, turn: Turn) -> None:
        """End a worker that is out of time, and what a dead one has left."""
        if time.monotonic() > deadline(turn, self._pool.limits.timeout):
            self._pool.end(worker, turn)
            return
        for process in self._pool.processes(worker):
            if is_dead(process):
                end_process(process)


def deadline(turn: Turn, timeout: float) -> float:
    """Return the time of the monotonic clock until which a worker may be busy as it is.

    Parameters
    ----------
    turn : Turn
    timeout : float
        Seconds, of the limits.
    """
    if turn.mark is None:
        return inf
    try:
        return read_mark(turn.mark).deadline
    except FileNotFoundError:
        return turn.begun + timeout + BEGINNING


def is_dead(process: BaseProcess) -> bool:
    """Tell whether a process has ended, without burying it: that is for whoever waits for it."""
    if process.pid is None or not hasattr(os, "waitid"):
        return False
    try:
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return False
