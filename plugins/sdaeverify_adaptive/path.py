"""A Brownian path with random access: repeated evaluations at any time, in any order, agree bit for bit.

Time is counted in ticks, 2^20 up to the horizon. On the grid of 2^13 steps the path is that of the package's noise
source. A time between grid points is reached by repeated halving, as in `LevelNoise.halved`, with normal variables
that are a hash of the position of the half. Therefore W and int W ds at a tick are functions of the address and of
the tick alone. Times between two ticks are refused.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Increment, UsageError
from sdaeverify.studying import Brownian, LevelNoise, Source

from .hashed import key_of, normals

TICKS = 2**20
# The grid: COARSEST steps, each refined to LEVEL, 2^13 steps in total.
COARSEST, LEVEL = 16, 9
GRID = COARSEST * 2**LEVEL
PER_STEP = TICKS // GRID
# Largest distance of a time from a tick, in ticks, for rounding in a sum of steps.
ROUNDING = 1e-6


class Point(NamedTuple):
    """A time on each path, with the values of the path.

    Attributes
    ----------
    tick : ndarray of int, shape (P,)
    W : ndarray, shape (l, P)
        Unit sqrt(time).
    J : ndarray, shape (l, P)
        int_0^t W ds, unit time^(3/2).
    """

    tick: Array
    W: Array
    J: Array


@dataclass(frozen=True, eq=False)
class Path:
    """Brownian motions of one block of paths, by random access.

    Attributes
    ----------
    source : Source
        Address of the block.
    horizon : float
        Final time T.
    W, J : ndarray, shape (GRID + 1, paths of the block, l)
        The motions and their time integrals on the grid.
    rows : ndarray of int, shape (P,)
        Selected paths of the block.
    """

    source: Source
    horizon: float
    W: Array
    J: Array
    rows: Array

    @property
    def paths(self) -> int:
        """Number P of paths."""
        return len(self.rows)

    @property
    def dimension(self) -> int:
        """Number l of Brownian motions."""
        return int(self.W.shape[-1])

    @property
    def tick(self) -> float:
        """Length of a tick."""
        return self.horizon / TICKS

    @cached_property
    def key(self) -> int:
        """Key of the hash."""
        return key_of(self.source)

    def only(self, paths: Array) -> "Path":
        """Return a subset of the paths."""
        return replace(self, rows=self.rows[paths])

    def ticks_of(self, t: Array | float) -> Array:
        """Convert times to ticks.

        Raises
        ------
        UsageError
            If a time is not a tick, or lies outside [0, T].
        """
        exact = np.asarray(t, dtype=float) / self.tick
        found = np.rint(exact)
        wrong = ~((np.abs(exact - found) <= ROUNDING) & (found >= 0) & (found <= TICKS))
        if wrong.any():
            time = np.broadcast_to(t, wrong.shape)[wrong].flat[0]
            raise UsageError(f"the path is known at multiples of {self.tick:.6g} up to {self.horizon}, got {time!r}")
        return found.astype(np.int64)

    def at(self, tick: Array | int) -> Point:
        """Return the path at a tick.

        Parameters
        ----------
        tick : ndarray of int, shape (P,), or int
            Ticks from 0 to 2^20.

        Raises
        ------
        UsageError
            If a tick is not an integer or is out of range.
        """
        given = np.asarray(tick)
        if not (np.issubdtype(given.dtype, np.integer) and np.all((given >= 0) & (given <= TICKS))):
            raise UsageError(f"the path is known at whole ticks from 0 to {TICKS}, got {tick!r:.200}")
        ticks = np.broadcast_to(given, (self.paths,)).astype(np.int64)
        step, rest = np.divmod(ticks, PER_STEP)
        W, J = self.W[step, self.rows].T, self.J[step, self.rows].T
        between = np.flatnonzero(rest)
        if between.size:
            W, J = W.copy(), J.copy()
            W[:, between], J[:, between] = self._inside(step[between], rest[between], self.rows[between])
        return Point(ticks, W, J)

    def _inside(self, step: Array, rest: Array, rows: Array) -> tuple[Array, Array]:
        h, size = self.horizon / GRID, PER_STEP
        W, J = self.W[step, rows].T, self.J[step, rows].T
        known = between(Point(step, W, J), Point(step, self.W[step + 1, rows].T, self.J[step + 1, rows].T), h)
        node = step + GRID
        while np.any(rest):
            dW, H = _fields(known)
            xi = normals(self.key, node, rows, (2, 1, self.dimension))
            fine = LevelNoise(dW[None], H[None]).halved(h, xi)
            h, size = 0.5 * h, size // 2
            left, right = fine.increment(0), fine.increment(1)
            later = rest >= size
            J = np.where(later, J + h * W + left.time_integral(h), J)
            W = np.where(later, W + left.dW, W)
            (a, b), (c, d) = _fields(left), _fields(right)
            known = Increment(np.where(later, c, a), np.where(later, d, b))
            node, rest = 2 * node + later, rest - size * later
        return W, J

    def between(self, begin: Point, end: Point) -> Increment:
        """Return dW and H between two points.

        Parameters
        ----------
        begin, end : Point
            Points, the second later than the first on each path.
        """
        return between(begin, end, (end.tick - begin.tick) * self.tick)


def between(begin: Point, end: Point, h: Array | float) -> Increment:
    """Return dW and H = (J(t+h) - J(t))/h - W(t) - dW/2 over a step.

    Parameters
    ----------
    begin, end : Point
    h : ndarray, shape (P,), or float
        Length of the step.
    """
    dW = end.W - begin.W
    return Increment(dW, (end.J - begin.J) / h - begin.W - 0.5 * dW)


def brownian_path(source: Source, dimension: int, horizon: float) -> Path:
    """Return the path at an address, that of a run with at least 16 steps for a problem that draws H.

    Parameters
    ----------
    source : Source
        Seed, label of the problem, block and number of paths.
    dimension : int
        Number l of Brownian motions.
    horizon : float
        Final time.
    """
    paths, h = source.used or source.paths, horizon / GRID
    W, J = np.zeros((2, GRID + 1, paths, dimension))
    steps = islice(Brownian(source, dimension, horizon / COARSEST, LEVEL).steps(), COARSEST)
    for begin, levels in enumerate(steps):
        part = slice(begin * 2**LEVEL + 1, (begin + 1) * 2**LEVEL + 1)
        dW, H = _fields(levels[-1])
        W[part] = np.swapaxes(dW, 1, 2)
        J[part] = np.swapaxes(h * (H + 0.5 * dW), 1, 2)
    np.cumsum(W, axis=0, out=W)
    J[1:] += h * W[:-1]
    np.cumsum(J, axis=0, out=J)
    return Path(source, horizon, W, J, np.arange(paths))


def _fields(noise: Increment | LevelNoise) -> tuple[Array, Array]:
    """Return dW and H, which a path always has."""
    assert noise.H is not None
    return noise.dW, noise.H
