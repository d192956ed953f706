"""What determines the numbers of a run, beside the problem and the scheme."""

from dataclasses import dataclass
from functools import cached_property

from .errors import UsageError

FEWEST_PATHS = 40
FINEST_STEPS = 2**20
LARGEST_BLOCK = 2**20


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Sample size, step sizes and level of confidence.

    Attributes
    ----------
    paths : int
        Number of paths M.
    coarsest : int
        Steps N_0 of the coarsest level; errors are compared at its grid times.
    levels : int
        Number L of levels; level l makes N_0 2^l steps.
    seed : int
    confidence : float
        Of the two-sided intervals that verdicts are taken from.
    block : int
        Paths simulated together; part of what determines the noise.

    Raises
    ------
    UsageError
        If a value is out of its range.
    """

    paths: int = 8192
    coarsest: int = 8
    levels: int = 6
    seed: int = 20170601
    confidence: float = 0.99
    block: int = 4096

    def __post_init__(self) -> None:
        _require(self.paths >= FEWEST_PATHS, "paths", f"at least {FEWEST_PATHS}", self.paths)
        _require(self.coarsest >= 1, "the coarsest number of steps", "at least 1", self.coarsest)
        _require(self.levels >= 3, "levels", "at least 3, or no slope can be told", self.levels)
        _require(self.steps[-1] <= FINEST_STEPS, "the finest number of steps", "at most 2^20", self.steps[-1])
        _require(0 <= self.seed < 2**63, "seed", "between 0 and 2^63 - 1", self.seed)
        _require(0.5 <= self.confidence < 1, "confidence", "between 0.5 and 1", self.confidence)
        _require(FEWEST_PATHS <= self.block <= LARGEST_BLOCK, "block", f"between {FEWEST_PATHS} and 2^20", self.block)

    @cached_property
    def steps(self) -> tuple[int, ...]:
        """Number of steps of each level, coarsest first."""
        return tuple(self.coarsest * 2**level for level in range(min(self.levels, 64)))

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return -(-self.paths // self.block)

    def paths_of(self, block: int) -> int:
        """Return the number of paths of a block: the last one may be smaller."""
        return min(self.block, self.paths - block * self.block)


def _require(condition: bool, name: str, expected: str, given: object) -> None:
    if not condition:
        raise UsageError(f"{name} must be {expected}, got {given}")
