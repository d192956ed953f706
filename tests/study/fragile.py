"""Worker processes that die as they are told to, in none of which anything runs."""

import pickle
import time
from concurrent.futures import Future
from pathlib import Path

from pebble import ProcessExpired

from facade import DIED, FORMAT, NO_MEASURE, NOBODY, Limits, Processes

BOTH = {("milstein", "strong"), ("milstein", "weak")}
TWICE = f"{DIED} of SIGKILL, possibly out of memory, twice"


class Fragile(Processes):
    """Dies where a call is about a scheme and a measure, with a mark of who is said to have done it."""

    active = True

    def __init__(self, guilty=(), blamed=None, deadline=float("inf")):
        super().__init__(1, limits=Limits(5.0))
        self.guilty, self.blamed, self.deadline, self.calls = set(guilty), blamed, deadline, []

    @property
    def marks(self):
        """What is left of marks."""
        return list(Path(self._marks.name).iterdir())

    def submit(self, fn, /, *args):
        """Make a call, or die of it or never come back."""
        _, argument, mark, _ = args
        entries = pickle.loads(argument).entries
        names = [(entry.scheme.name, measure.name) for entry in entries for measure in entry.measures]
        self.calls.append(len(names))
        future = Future()
        if self.guilty.isdisjoint(names):
            future.set_result(fn(*args))
        else:
            mark.write_bytes(FORMAT.pack(*self.blamed(entries), self.deadline))
            if self.deadline > time.monotonic():
                future.set_exception(ProcessExpired("it died", code=-9))
        return future


def blaming(name, measure=None):
    """Return a function that blames a scheme by its name, wherever it is, or one of its measures."""

    def blamed(entries):
        index = next((i for i, entry in enumerate(entries) if entry.scheme.name == name), NOBODY)
        one = measure is not None and index != NOBODY
        return index, [m.name for m in entries[index].measures].index(measure) if one else NO_MEASURE

    return blamed
