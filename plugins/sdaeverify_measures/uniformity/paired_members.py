"""Weak and strong errors of the members of a family with the same noise, if no error is exact.

X_l is the scheme with step size h_l, phi an observable. If eps is at least 16 of its steps, Y is an Euler path of
the penalised equation, Laurent (2022), (1.5), with a quarter of the shortest step: a solution that is independent of
the scheme. Otherwise such a path is not stable or not accurate, and the scheme is compared with itself:

    weak      phi(X_l(T)) - phi(Y(T)),   or   phi(X_l(T)) - phi(X_{l+1}(T)),
    strong    |X_l(T) - X_{l+1}(T)|^2.

Theorem 2.7 bounds the means of either kind by C h^{1/2} with one C for all eps, and so their supremum over eps. With
a weak penalty, paths may reach points where the Gram matrix is singular, so that steps have no root: the paths of
such an eps end early, and are counted.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Parts, Problem, Scheme, Settings
from sdaeverify.measuring import group_sums
from sdaeverify.probing import StiffnessFamily
from sdaeverify.studying import Brownian, LevelNoise, Source

from .._members import member, stiffnesses

PURPOSE = "uniformity"
# Maximum number of levels of the scheme, and halvings from the finest of them to the Euler path.
LEVELS, FINER = 5, 2
# An Euler path is used if eps is at least this multiple of its step.
STIFFEST = 16.0
# Two eps per decade from a tenth of the shortest step to ten of the longest, and one per two decades beyond.
NEAR = 10.0
# Every fourth path of the run is used, but all up to a number; and the number of paths simulated together.
SHARE, ALL, BLOCK = 4, 1024, 1024
# Largest share of paths that may meet a step without a root.
FAILED = 0.01


class PairedErrors(NamedTuple):
    """Sums over G groups of paths for E stiffness parameters, L step sizes and Q observables.

    Attributes
    ----------
    weak : ndarray, shape (E, G, L, Q)
    strong : ndarray, shape (E, G, L)
    blurred : ndarray, shape (E, G, Q)
        phi(Y) - phi(Y'), Y' an Euler path with twice the step; 0 if there is none.
    values : ndarray, shape (E, G, 2, Q)
        phi(X) and phi(X)^2, X being the finest path.
    failed, lost : ndarray, shape (E, G, L + 1)
        Numbers of paths with a step without a root, and of other paths that are not finite at T.
    counts : ndarray, shape (G,)
    h : ndarray, shape (L,)
        From coarse to fine, each half of the previous one.
    eps : ndarray, shape (E,)
        Ascending.
    """

    weak: Array
    strong: Array
    blurred: Array
    values: Array
    failed: Array
    lost: Array
    counts: Array
    h: Array
    eps: Array


def paired_errors(scheme: Scheme, view: Problem, settings: Settings) -> PairedErrors:
    """Return the errors on a share of the run's paths, whose noise is determined by the seed.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Requires that `why_not_family` returns an empty string.
    settings : Settings
        Provides the number of paths, the seed and the numbers of steps, of which the first five are used.
    """
    h = view.horizon / np.array(settings.steps[:LEVELS])
    paths, grid = max(settings.paths // SHARE, min(settings.paths, ALL)), _grid(h)
    found: list[tuple[Array, ...]] = []
    with np.errstate(all="ignore"):
        for eps in grid:
            blocks = [
                [
                    group_sums(part)
                    for part in _Paths(scheme, member(view, eps), h, size).errors(source, FAILED * paths)
                ]
                for index, size in enumerate(_sizes(paths))
                for source in [Source(settings.seed, PURPOSE, index, size)]
            ]
            found.append(tuple(np.sum(part, axis=0) for part in zip(*blocks, strict=True)))
    counts = np.sum([group_sums(np.ones(size)) for size in _sizes(paths)], axis=0)
    sums = [np.array(part) for part in zip(*found, strict=True)]
    return PairedErrors._make([*sums, counts, h[:-1], grid])


def run_of(paths: float) -> float:
    """Return the number of paths of a run for which the given number of paths is used."""
    return paths if paths <= ALL else SHARE * paths


def _grid(h: Array) -> Array:
    coarse, fine = stiffnesses(1), stiffnesses(2)
    return np.unique([*coarse[::2], coarse[-1], *fine[(fine >= h[-1] / NEAR) & (fine <= h[0] * NEAR)]])


def _sizes(paths: int) -> list[int]:
    blocks = -(-paths // BLOCK)
    return [paths * (index + 1) // blocks - paths * index // blocks for index in range(blocks)]


class _Paths:
    """The paths of one member at all step sizes, and two Euler paths of it if it is not too stiff."""

    def __init__(self, scheme: Scheme, problem: StiffnessFamily, h: Array, paths: int) -> None:
        self.scheme, self.problem, self.h, self.drift = scheme, problem, h, problem.ito().drift
        self.steppers = [scheme.prepare(problem, float(each)) for each in h]
        self.states = [scheme.start(problem, paths, float(each)) for each in h]
        self.failed = np.zeros((len(h), paths), dtype=bool)
        explicit = problem.eps >= STIFFEST * h[-1] / 2**FINER
        self.euler = [problem.initial(paths)] * 2 if explicit else []

    def errors(self, source: Source, most: float) -> tuple[Array, ...]:
        """Return the first six fields of `PairedErrors`, without the first axis and with paths last.

        The paths end early if more than `most` met a step without a root, because their errors are not used. The
        coarsest step is exempt, because it may be too long for all eps.
        """
        steps = Brownian(source, self.problem.noise_dim, float(self.h[0]), len(self.h) - 1 + FINER).steps()
        for _, levels in zip(range(round(self.problem.horizon / self.h[0])), steps, strict=False):
            self._advance(levels)
            if self.failed[1:].sum(axis=1).max() > most:
                break
        parts = [self.scheme.parts(self.problem, state) for state in self.states]
        x, phi = np.stack([each["x"] for each in parts]), np.stack([self._values(each) for each in parts])
        weak, blurred = phi[:-1] - phi[1:], np.zeros_like(phi[0])
        if self.euler:
            fine, coarse = (self._values(self.problem.parts(y)) for y in self.euler)
            weak, blurred = phi[:-1] - fine, fine - coarse
        strong = ((x[:-1] - x[1:]) ** 2).sum(axis=1)
        lost = ~np.isfinite(x).all(axis=1) & ~self.failed
        return weak, strong, blurred, np.stack([phi[-1], phi[-1] ** 2]), self.failed, lost

    def _advance(self, levels: Sequence[LevelNoise]) -> None:
        for level, (h, step) in enumerate(zip(self.h, self.steppers, strict=True)):
            for n in range(len(levels[level].dW)):
                increment = self.scheme.law.increment(levels[level].increment(n), float(h))
                result = step(self.states[level], 0.0, increment)
                self.states[level] = result.state
                if result.failed is not None:
                    self.failed[level] |= result.failed
        for index, noise in enumerate(levels[: -1 - len(self.euler) : -1]):
            h = self.h[0] / len(noise.dW)
            for dW in noise.dW:
                x = self.euler[index]
                self.euler[index] = x + h * self.drift(0.0, x) + self.problem.strength * dW

    def _values(self, parts: Parts) -> Array:
        T = self.problem.horizon
        return np.stack([np.asarray(phi(T, parts)) for phi in self.problem.observables.values()])
