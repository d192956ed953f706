"""Chains at one or several step sizes on the same noise, and the time averages of observables along them."""

from typing import Any

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...noise.brownian import Brownian, Source
from ...numerics.statistics import EPS
from ..tracks import Track
from .plan import SEGMENTS

STATIONARY_Z = 2.5


class Chains:
    """Chains at one or several step sizes on the same noise.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form; its observables are averaged.
    source : Source
        Of the noise; its paths are the chains.
    h : float
        Coarsest step size.
    levels : int
        Number of step sizes h, h/2, h/4, ...
    """

    def __init__(self, scheme: Scheme, view: Any, source: Source, h: float, levels: int = 1) -> None:
        self.view, self.h, self.steps, self.paths = view, h, 0, source.paths
        self.tracks = [Track(scheme, view, level, h / 2**level, source.paths) for level in range(levels)]
        self.pieces = Brownian(source, view.noise_dim, h, levels - 1, "H" in scheme.noise).pieces()

    def advance(self, steps: int) -> None:
        """Make coarsest steps, and note the chains that blew up."""
        for _ in range(steps):
            self._step()
        self._find_lost()

    def average(self, steps: int) -> Array:
        """Return the means of the O observables over the next coarsest steps, shape (L, O, P)."""
        total = self._zeros()
        for _ in range(steps):
            self._step()
            self._add_values(total)
        self._find_lost()
        return total / steps

    def values(self) -> Array:
        """Return the observables as they are now, shape (L, O, P)."""
        total = self._zeros()
        self._add_values(total)
        return total

    def record(self, steps: int) -> tuple[Array, bool]:
        """Return the means over a record, shape (L, O, P), and whether it looks stationary.

        It does if over all chains |z| < 2.5 for the mean over its first tenth less that over its second half.
        """
        parts = np.stack([self.average(steps // SEGMENTS) for _ in range(SEGMENTS)])
        return parts.mean(axis=0), not _moves(parts[0] - parts[SEGMENTS // 2 :].mean(axis=0), parts)

    def _step(self) -> None:
        for piece in next(self.pieces):
            self.tracks[piece.level].advance(piece.noise, ())
        self.steps += 1

    def _zeros(self) -> Array:
        return np.zeros((len(self.tracks), len(self.view.observables), self.paths))

    def _add_values(self, total: Array) -> None:
        t = self.steps * self.h
        for level, track in enumerate(self.tracks):
            parts = track.parts()
            for index, observable in enumerate(self.view.observables.values()):
                total[level, index] += observable(t, parts)

    def _find_lost(self) -> None:
        for track in self.tracks:
            track.find_lost(0.0)


def _moves(difference: Array, parts: Array) -> bool:
    # A difference of rounding size has no law that could be tested.
    mean, rounding = difference.mean(axis=-1), 1e3 * EPS * np.abs(parts).max(axis=(0, -1))
    z = mean / (difference.std(axis=-1, ddof=1) / np.sqrt(difference.shape[-1]))
    return bool(np.any((np.abs(z) >= STATIONARY_Z) & (np.abs(mean) > rounding)))
