"""What is noted on the way of a run."""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array, Mask, Parts
from ...contracts.experiment import EACH, MAX, MEAN, Note, Noted
from ...contracts.measure import Snapshot
from ...contracts.tally import Tally
from ...errors import FAULTS, ProblemError, one_line
from ...forms import Problem
from ...simulate.tracks import Track


class Notebook:
    """The observer of one track: one note; what goes wrong in it costs this note only.

    Parameters
    ----------
    track : Track
    problem : Problem
        As registered: the observables are its own.
    note : Note
    steps : int
        Number of steps of the run.
    """

    def __init__(self, track: Track, problem: Problem, note: Note, steps: int) -> None:
        self.track, self.problem, self.note, self.h = track, problem, note, problem.horizon / steps
        self.wanted: list[Sequence[int]] = [()] * track.level + [note.steps(steps)]
        self.at: list[int] = []
        self.values: list[Array] = []
        self.without_root: list[Mask] = []
        self.lost: list[Mask] = []
        self.error = ""

    def after_step(self, level: int, step: int, parts: Parts) -> None:  # noqa: ARG002 - there is one level
        """Note the value after this step."""
        if self.error:
            return
        try:
            found = self._value(step * self.h, parts)
        except FAULTS as error:
            self.error = one_line(error)
            return
        self.track.find_lost(0.0)
        # What is lost has no value, also where a function gives it a finite one.
        self._keep(step, np.where(self.track.lost, np.nan, found))

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Note nothing: a track has one level."""

    def tally(self) -> Tally:
        """Return nothing: what is noted is merged by experiments."""
        return Tally()

    def noted(self) -> Noted:
        """Return what was noted."""
        if self.error or not self.values:
            return Noted(error=self.error or "not reached")
        values = np.stack(self.values)
        if self.note.over == MEAN:
            values = values / len(self.at)
        at = tuple(self.at) if self.note.over == EACH else (self.at[-1],)
        return Noted(values, np.stack(self.without_root), np.stack(self.lost), at)

    def _value(self, t: float, parts: Parts) -> Array:
        of, known = self.note.of, self.problem.observables
        if not isinstance(of, str):
            return of(self.problem, t, parts)
        if of not in known:
            raise ProblemError(f"the problem has no observable {of!r}; it has {', '.join(known)}")
        return known[of](t, parts)

    def _keep(self, step: int, value: Array) -> None:
        if self.values and self.note.over != EACH:
            before = self.values.pop()
            value = np.fmax(before, value) if self.note.over == MAX else before + value
            # fmax passes over what is not there, and a lost path has no largest value.
            value = np.where(self.track.lost, np.nan, value)
            self.without_root.clear()
            self.lost.clear()
        self.at.append(step)
        self.values.append(value)
        self.without_root.append(self.track.failed.copy())
        self.lost.append(self.track.lost.copy())
