"""What the uniform measure notes between grid points: linear interpolants against the scheme's finest paths."""

from collections import deque
from collections.abc import Container, Sequence
from itertools import pairwise

import numpy as np

from ...arrays import Array, Parts
from ...contracts.settings import Settings
from ...contracts.tally import EXTREMES, Tally, largest
from ..path_errors.errors import POWERS, STATE, power_sums

# Halvings between a level and the grid on which its interpolant is compared.
HALVINGS = 2
POINTS = 2**HALVINGS
CONTINUOUS = "continuous"


class ContinuousErrors:
    """Notes c_l = max_t |X_l(t) - X(t)|, X_l the linear interpolant of level l, X the scheme at the finest level.

    The maximum is over the quarters of each step. A Brownian path deviates from its interpolant on N steps by
    sqrt(h) times a maximum over N independent bridges, and with the same points inside each step that maximum is the
    same part of the supremum at all levels: it does not tilt a slope, as the finest grid would, which resolves fewer
    points of a short step. So levels two halvings coarser than the finest are compared, and coarser ones.

    A level is always ahead of the finer ones, by a few steps: only these are held, however many there are.

    Parameters
    ----------
    parts : mapping of str to ndarray, shape (n, P)
        Initial components, of which those are noted that are named.
    names : sequence of str
    settings : Settings
    """

    def __init__(self, parts: Parts, names: Sequence[str], settings: Settings) -> None:
        self.names, self.settings = list(names), settings
        self.top = settings.levels - 1
        self.levels = range(max(0, settings.levels - HALVINGS))
        self.wanted: Sequence[Container[int]] = [
            range(1, steps + 1) if level in self.levels or level == self.top else ()
            for level, steps in enumerate(settings.steps)
        ]
        start = self._rows(parts)
        self.ahead = [deque([start]) for _ in self.levels]
        self.inside: list[list[Array]] = [[] for _ in self.levels]
        ends = np.cumsum([0, *(len(parts[name]) for name in self.names)]).tolist()
        self.slices = [slice(*pair) for pair in pairwise(ends)]
        self.squares = np.zeros((len(self.quantities), len(self.levels), start.shape[-1]))

    @property
    def quantities(self) -> list[str]:
        """The components and, where there are several, the full state."""
        return self.names if len(self.names) == 1 else [*self.names, STATE]

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Hold a level's value, or compare with the finest one."""
        x = self._rows(parts)
        if level < self.top:
            self.ahead[level].append(x)
            return
        for coarse in self.levels:
            if step % 2 ** (self.top - HALVINGS - coarse) == 0:
                self.inside[coarse].append(x)
                if len(self.inside[coarse]) == POINTS:
                    self._compare(coarse)

    def tally(self) -> Tally:
        """Return sums of the errors' powers over groups of paths, and the largest errors."""
        errors = dict(zip(self.quantities, np.sqrt(self.squares), strict=True))
        return Tally(
            sums={f"{CONTINUOUS} {name}": power_sums(value, len(POWERS)) for name, value in errors.items()},
            largest={f"{CONTINUOUS} {name}": largest(value, EXTREMES) for name, value in errors.items()},
        )

    def _compare(self, level: int) -> None:
        """Compare at the quarters of the step that ends here."""
        left = self.ahead[level].popleft()
        chord, rise = left.copy(), (self.ahead[level][0] - left) / POINTS
        gap = np.empty_like(chord)
        for x in self.inside[level]:
            chord += rise
            np.subtract(chord, x, out=gap)
            for noted, square in zip(self.squares, self._squares(gap), strict=True):
                np.maximum(noted[level], square, out=noted[level])
        self.inside[level] = []

    def _rows(self, parts: Parts) -> Array:
        return np.concatenate([parts[name] for name in self.names])

    def _squares(self, gap: Array) -> list[Array]:
        # einsum: a sum over few rows takes several times as long.
        squares = [np.einsum("np,np->p", gap[rows], gap[rows]) for rows in self.slices]
        return squares if len(squares) == 1 else [*squares, sum(squares[1:], squares[0])]
