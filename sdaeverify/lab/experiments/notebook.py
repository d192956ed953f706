"""What is noted on the way of a run: observables after some of its steps."""

from collections.abc import Container, Sequence

import numpy as np

from ...arrays import Parts
from ...contracts.measure import Snapshot
from ...contracts.tally import Tally
from ...forms import Problem
from ...simulate.tracks import Track
from .quantity import Noted, Value


class Notebook:
    """The observer of one track.

    Parameters
    ----------
    track : Track
    problem : Problem
        As registered: the observables are its own.
    values : sequence of Value
        What is noted, all with the track's number of steps.

    Attributes
    ----------
    noted : dict of Value to Noted
    """

    def __init__(self, track: Track, problem: Problem, values: Sequence[Value]) -> None:
        self.track, self.problem, self.values = track, problem, values
        steps = frozenset(value.at for value in values)
        self.wanted: Sequence[Container[int]] = [frozenset()] * track.level + [steps]
        self.noted: dict[Value, Noted] = {}

    def after_step(self, level: int, step: int, parts: Parts) -> None:  # noqa: ARG002 - there is one level
        """Note the observables that are wanted after this step."""
        self.track.find_lost(0.0)
        lost, without_root = self.track.lost.copy(), self.track.failed.copy()
        for value in (value for value in self.values if value.at == step):
            t = self.problem.horizon * (step / value.steps)
            found = self.problem.observables[value.observable](t, parts)
            # What is lost has no value, also where an observable gives it a finite one.
            self.noted[value] = Noted(np.where(lost, np.nan, found), without_root, lost)

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Note nothing: a track has one level."""

    def tally(self) -> Tally:
        """Return nothing: samples are merged by experiments."""
        return Tally()
