"""Simulations for the comparison of truths: Euler's scheme and known solutions, on the same Brownian paths.

They share nothing with the ensemble that judges schemes but the noise.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ...arrays import Parts
from ...forms import DelaySDAE, DelayState
from ...forms.truths import Pathwise
from ...noise.brownian import Increment, LevelNoise, Source, brownian_steps
from ..check import Inapplicable

# Steps of the coarsest grid: simulations are compared at its last time and half way.
COARSEST = 8
SEED = 1


class Walker:
    """A state that steps of one length advance.

    Parameters
    ----------
    state : object
    advance : callable, (state, t, noise) -> state
    parts : callable, (t, state) -> mapping of str to ndarray
    level : int
        Its steps are 2^-level coarsest ones.
    """

    def __init__(
        self,
        state: Any,
        advance: Callable[[Any, float, Increment], Any],
        parts: Callable[[float, Any], Parts],
        level: int,
    ) -> None:
        self.state, self.advance, self.of, self.level, self.step = state, advance, parts, level, 0

    def walk(self, noise: LevelNoise, h: float) -> None:
        """Make the steps of one coarsest step, each of length h."""
        for index in range(len(noise.dW)):
            self.state = self.advance(self.state, self.step * h, noise.increment(index))
            self.step += 1

    def parts(self, t: float) -> Parts:
        """Return the named components at a time that it has reached."""
        return self.of(t, self.state)


def euler(problem: Any, level: int, paths: int) -> Walker:
    """Return Euler-Maruyama on the Ito equation of a problem, or on its equation with delay.

    Raises
    ------
    Inapplicable
        If there is no such equation.
    """
    h = problem.horizon / (COARSEST * 2**level)
    if isinstance(problem, DelaySDAE) and (problem.delay or problem.constraints):
        return _delayed(problem, level, h, paths)
    ito = problem.ito()
    if ito is None:
        raise Inapplicable(f"a {type(problem).__name__} has no Ito equation to simulate")

    def advance(x: Any, t: float, noise: Increment) -> Any:
        return x + h * ito.drift(t, x) + ito.diffused(t, x, noise.dW)

    return Walker(ito.initial(paths), advance, lambda _, x: ito.parts(x), level)


def _delayed(problem: DelaySDAE, level: int, h: float, paths: int) -> Walker:
    recall = problem.recall(h, paths)

    def advance(state: DelayState, t: float, noise: Increment) -> DelayState:
        (x, y), lagged = state, state.x if recall is None else recall.lagged()
        x = x + h * problem.drift(t, x, lagged, y) + problem.diffused(t, x, lagged, y, noise.dW)
        if recall is not None:
            recall.push(x)
        return DelayState(x, problem.eliminated(t + h, x, x if recall is None else recall.lagged()))

    def without_y(state: DelayState, t: float, noise: Increment) -> DelayState:
        lagged = state.x if recall is None else recall.lagged()
        x = state.x + h * problem.drift(t, state.x, lagged, state.y)
        x = x + problem.diffused(t, state.x, lagged, state.y, noise.dW)
        if recall is not None:
            recall.push(x)
        return DelayState(x, state.y)

    step = advance if problem.constraints else without_y
    return Walker(problem.initial(paths), step, lambda _, state: problem.parts(state), level)


def known(problem: Any, truth: Pathwise, level: int, paths: int) -> Walker:
    """Return the solution that a problem knows, which draws its further normals beside the Brownian paths."""
    h = problem.horizon / (COARSEST * 2**level)
    rng = np.random.default_rng(SEED)

    def advance(z: Any, t: float, noise: Increment) -> Any:
        xi = rng.standard_normal((truth.extra_normals, paths)) if truth.extra_normals else None
        return truth.advance(z, t, h, noise._replace(xi=xi))

    return Walker(truth.start(paths), advance, truth.parts, level)


def together(
    problem: Any, label: str, walkers: Sequence[Walker], paths: int, *, mirrored: bool = False
) -> Iterator[float]:
    """Advance walkers on the same Brownian paths and yield the times at which they meet: T/2 and T.

    Parameters
    ----------
    problem : Problem
    label : str
        Of the problem: the noise is drawn by name.
    walkers : sequence of Walker
    paths : int
        Of each walker.
    mirrored : bool
        Whether the second half of the paths has the noise of the first with the other sign.
    """
    finest, H = max(walker.level for walker in walkers), problem.horizon / COARSEST
    source = Source(SEED, f"{label} in the kit", 0, paths // 2 if mirrored else paths)
    steps = brownian_steps(source, problem.noise_dim, H, finest)
    for n, levels in zip(range(COARSEST), steps, strict=False):
        for walker in walkers:
            noise = levels[walker.level]
            walker.walk(_both(noise) if mirrored else noise, H / 2**walker.level)
        if n + 1 in {COARSEST // 2, COARSEST}:
            yield (n + 1) * H


def _both(noise: LevelNoise) -> LevelNoise:
    assert noise.H is not None
    return LevelNoise(*(np.concatenate([part, -part], axis=-1) for part in (noise.dW, noise.H)))
