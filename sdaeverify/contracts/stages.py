"""Stages, looks and blocks of a run: how many levels and paths each has.

A *stage* has a number of levels, a *look* judges a cell after some of the blocks of a stage, and a *block* is the
largest number of paths simulated together.
"""

from bisect import bisect_right
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import Self

FEWEST_PATHS, MOST_PATHS = 40, 10**9
# Paths of the first block, the cost of a cell that is easy to decide, and the ratio of the total to it after the
# second block. Paths alone decide from 800 on (`DEEP_PATHS`), so a look with fewer would hardly settle anything.
FIRST_BLOCK, SECOND_TOTAL = 256, 4
FINEST_STEPS = 2**20
LARGEST_BLOCK = 2**20
# In place of the index of a block: the evidence from single steps, found before any path is drawn.
SCREENING = -1


@dataclass(frozen=True, kw_only=True)
class Stages:
    """Numbers of levels, paths and looks; see `Settings`, which checks them.

    Attributes
    ----------
    paths, coarsest, levels, first_levels, block, max_looks : int
    """

    paths: int = 8192
    coarsest: int = 8
    levels: int = 6
    first_levels: int = 4
    block: int = 4096
    max_looks: int = 6

    @property
    def steps(self) -> tuple[int, ...]:
        """Number of steps of each level, coarsest first."""
        return tuple(self.coarsest * 2**level for level in range(min(self.levels, 64)))

    @property
    def guards(self) -> Self:
        """The same settings with only the first levels."""
        return self if self.first_levels >= self.levels else replace(self, levels=self.first_levels)

    @property
    def stages(self) -> tuple[int, ...]:
        """Numbers of levels of the successive stages of sampling, relative to `levels`.

        The first stage uses the levels of guards, the second all levels. Each further stage adds a finer level on
        half as many paths, as long as these are enough to decide by themselves. So no stage costs more than all paths
        on all levels.
        """
        first = () if self.guards is self else (self.first_levels - self.levels,)
        enough = (self.paths // (FIRST_BLOCK * SECOND_TOTAL)).bit_length() - 1
        room = (FINEST_STEPS // self.steps[-1]).bit_length() - 1
        return (*first, 0, *range(1, 1 + min(enough, room)))

    def at(self, stage: int) -> Self:
        """Return the settings of a stage, identified by its number of levels relative to `levels`."""
        if stage == 0:
            return self
        if stage < 0:
            return self.guards
        return replace(self, levels=self.levels + stage, paths=self.paths >> stage)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of paths of each block; every block is drawn whole, and of the last one some paths may be unused."""
        sizes = [min(FIRST_BLOCK, self.block)]
        while (total := sum(sizes)) < self.paths:
            sizes.append(min(total if len(sizes) > 1 else (SECOND_TOTAL - 1) * total, self.block))
            if sizes[-1] == self.block:
                return (*sizes, *([self.block] * max(0, -(-(self.paths - total - self.block) // self.block))))
        return tuple(sizes)

    @property
    def totals(self) -> tuple[int, ...]:
        """Cumulative number of used paths up to and including each block."""
        return tuple(min(total, self.paths) for total in accumulate(self.sizes))

    @property
    def blocks(self) -> int:
        """Number of blocks of paths."""
        return len(self.sizes)

    @property
    def ends(self) -> tuple[int, ...]:
        """Number of blocks at the end of each look; each look but the last has at most half the paths of the next."""
        totals, ends = self.totals, [self.blocks]
        while len(ends) < self.max_looks and 2 * totals[0] <= totals[ends[-1] - 1]:
            ends.append(bisect_right(totals, totals[ends[-1] - 1] / 2))
        return tuple(reversed(ends))

    def paths_of(self, block: int) -> int:
        """Return the number of used paths of a block: all of them, except perhaps in the last block."""
        return self.totals[block] - (self.totals[block - 1] if block else 0)
