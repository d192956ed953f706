"""Exact solution on one block of paths, advanced once for all schemes."""

from typing import Any

import numpy as np

from ..arrays import Parts
from ..contracts.settings import Settings
from ..forms import Problem
from ..forms.truths import Pathwise
from ..noise.brownian import Increment, LevelNoise

# Halvings between the finest level and the fine reference run of a scheme. The effect of its error on a slope over
# four levels, at most 0.06 at order 1 and 0.15 at order 1/2, is part of the interval; another halving would double
# the cost.
OWN_REFERENCE = 3


class Reference:
    """The pathwise exact solution of a problem; without one, the level of each scheme's own reference run.

    An exact solution steps on the coarsest grid, or on the finest if it needs further normals. A solution of finite
    order runs one level finer than the finest, and once more at the finest to estimate its own error.

    Parameters
    ----------
    problem : Problem
    settings : Settings
    block : int
        Index of the block of paths.
    asked_for : bool, optional
        Whether a measure compares with it; if not, it makes no steps.

    Attributes
    ----------
    own : int or None
        Level of a scheme's own reference run, if the problem has no exact solution; else None.
    finest : int
        Finest level of noise that is drawn.
    level : int
        Level of the steps of the exact solution.
    """

    def __init__(self, problem: Problem, settings: Settings, block: int, *, asked_for: bool = True) -> None:
        self.truth, self.paths, self.drawn = problem.pathwise, settings.paths_of(block), settings.sizes[block]
        last = settings.levels - 1
        self.level, self.finest = _resolution(self.truth, last)
        self.own = self.finest if self.truth is None else None
        # Levy areas are computed from the finest level: with another finest level they would be different.
        if not (asked_for or "A" in problem.noise):
            self.finest = last
        self.h = [problem.horizon / (settings.coarsest * 2 ** (self.level - k)) for k in range(2)]
        self.states: list[Any] = []
        if self.truth is not None and asked_for:
            self.states = [self.truth.start(self.paths) for _ in range(1 if self.truth.exact else 2)]
        self.steps = [0 for _ in self.states]

    def advance(self, level: int, noise: LevelNoise, extra: np.random.Generator) -> None:
        """Make the steps of a piece of noise, if the exact solution steps at its level.

        Parameters
        ----------
        level : int
        noise : LevelNoise
            Successive steps of this level.
        extra : numpy.random.Generator
            Draws the further normals of an exact solution.
        """
        index = self.level - level
        if 0 <= index < len(self.states):
            self.states[index] = self._advance_state(index, noise, extra)
            self.steps[index] += len(noise.dW)

    def parts(self) -> list[Parts]:
        """Return the known components at full and, if inexact, at half resolution; empty if it makes no steps."""
        if self.truth is None or not self.states:
            return []
        t = self.steps[0] * self.h[0]
        return [self.truth.parts(t, state) for state in self.states]

    def _advance_state(self, index: int, noise: LevelNoise, extra: np.random.Generator) -> Any:
        assert self.truth is not None
        state, h = self.states[index], self.h[index]
        for step in range(len(noise.dW)):
            increment = noise.increment(step)
            if self.truth.extra_normals:
                increment = self._with_extra(increment, extra)
            state = self.truth.advance(state, (self.steps[index] + step) * h, h, increment)
        return state

    def _with_extra(self, increment: Increment, extra: np.random.Generator) -> Increment:
        assert self.truth is not None
        # A full block is drawn, as for W, so that the numbers of a path do not depend on the number of used paths.
        xi = extra.standard_normal((self.truth.extra_normals, self.drawn))
        return increment._replace(xi=xi[:, : self.paths])


def _resolution(truth: Pathwise | None, last: int) -> tuple[int, int]:
    if truth is None:
        return 0, last + OWN_REFERENCE
    if not truth.exact:
        return last + 1, last + 1
    return (last if truth.extra_normals else 0), last
