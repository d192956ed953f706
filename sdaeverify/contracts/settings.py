"""What determines the numbers of a run, beside the problem and the scheme."""

import re
from bisect import bisect_right
from dataclasses import dataclass, fields, replace
from itertools import accumulate
from math import isqrt
from numbers import Real
from operator import index
from typing import Any, TypedDict, Unpack

from ..errors import UsageError

FEWEST_PATHS, MOST_PATHS = 40, 10**9
# Paths of the first block: what a cell that is easy to decide costs; and how many times as many there are with the
# second: from 800 on (`DEEP_PATHS`) paths alone decide, so that a look with fewer would hardly settle anything.
FIRST_BLOCK, SECOND_TOTAL = 256, 4
FINEST_STEPS = 2**20
LARGEST_BLOCK = 2**20
# In place of the index of a block: what one step tells of a scheme on a problem, before any path is drawn.
SCREENING = -1
_RANGE = re.compile(r"([0-9]{1,9})\.\.([0-9]{1,9})")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Sample size, step sizes and level of confidence.

    Attributes
    ----------
    paths : int
        Largest number M of paths of a cell.
    coarsest : int
        Steps N_0 of the coarsest level; errors are compared at its grid times.
    levels : int
        Number L of levels; level l makes N_0 2^l steps.
    first_levels : int
        Of these, the coarsest that paths begin with. They are enough to guard what one step decides; what rests on
        the paths themselves is run again on all levels.
    seed : int
    confidence : float
        Of the two-sided intervals that verdicts are taken from.
    block : int
        Most paths simulated together; part of what determines the noise. The first block has 256 of them, the second
        768, the next as many as all before it, until this size is reached.
    max_looks : int
        How often at most a cell is judged, with at least twice the paths each time, until it is decided.
    tests_reserved : int
        Tests among which a run shares its error probability when it decides early: each look of each one-sided
        test has level (1 - confidence)/(tests_reserved max_looks).

    Raises
    ------
    UsageError
        If a value is out of its range.
    """

    paths: int = 8192
    coarsest: int = 8
    levels: int = 6
    first_levels: int = 4
    seed: int = 20170601
    confidence: float = 0.99
    block: int = 4096
    max_looks: int = 6
    tests_reserved: int = 1000

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            given = number(field.name, value) if field.name == "confidence" else whole(field.name, value)
            object.__setattr__(self, field.name, given)
        require(self.paths >= FEWEST_PATHS, "paths", f"at least {FEWEST_PATHS}", self.paths)
        require(self.paths <= MOST_PATHS, "paths", "at most 10^9", self.paths)
        require(self.coarsest >= 1, "the coarsest number of steps", "at least 1", self.coarsest)
        for name in ("levels", "first_levels"):
            given = getattr(self, name)
            require(given >= 3, name, "at least 3, or no slope can be told", given)
        require(self.steps[-1] <= FINEST_STEPS, "the finest number of steps", "at most 2^20", self.steps[-1])
        require(0 <= self.seed < 2**63, "seed", "between 0 and 2^63 - 1", self.seed)
        require(0.5 <= self.confidence < 1, "confidence", "between 0.5 and 1", self.confidence)
        require(1 <= self.max_looks <= 20, "max_looks", "between 1 and 20", self.max_looks)
        require(1 <= self.tests_reserved <= 10**9, "tests_reserved", "at least 1", self.tests_reserved)
        require(FEWEST_PATHS <= self.block <= LARGEST_BLOCK, "block", f"between {FEWEST_PATHS} and 2^20", self.block)

    @property
    def steps(self) -> tuple[int, ...]:
        """Number of steps of each level, coarsest first."""
        return tuple(self.coarsest * 2**level for level in range(min(self.levels, 64)))

    @property
    def guards(self) -> "Settings":
        """The same with the levels that paths begin with."""
        return self if self.first_levels >= self.levels else replace(self, levels=self.first_levels)

    @property
    def stages(self) -> tuple[int, ...]:
        """How many levels paths take beyond those of the settings, one stage after the other.

        They begin on the levels of guards and go on to all; then to one finer level after the other, each on half as
        many paths as the one before, as long as these are enough to decide by themselves. So no stage costs more than
        all paths on all levels.
        """
        first = () if self.guards is self else (self.first_levels - self.levels,)
        enough = (self.paths // (FIRST_BLOCK * SECOND_TOTAL)).bit_length() - 1
        room = (FINEST_STEPS // self.steps[-1]).bit_length() - 1
        return (*first, 0, *range(1, 1 + min(enough, room)))

    def at(self, stage: int) -> "Settings":
        """Return the settings of a stage, which is told by how many levels it has beyond these."""
        if stage == 0:
            return self
        if stage < 0:
            return self.guards
        return replace(self, levels=self.levels + stage, paths=self.paths >> stage)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of paths of each block; all are drawn, of the last one perhaps not all are used."""
        sizes = [min(FIRST_BLOCK, self.block)]
        while (total := sum(sizes)) < self.paths:
            sizes.append(min(total if len(sizes) > 1 else (SECOND_TOTAL - 1) * total, self.block))
            if sizes[-1] == self.block:
                return (*sizes, *([self.block] * max(0, -(-(self.paths - total - self.block) // self.block))))
        return tuple(sizes)

    @property
    def totals(self) -> tuple[int, ...]:
        """Number of paths of all blocks up to each one."""
        return tuple(min(total, self.paths) for total in accumulate(self.sizes))

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.sizes)

    @property
    def ends(self) -> tuple[int, ...]:
        """Number of blocks at the end of each look: all, before that at most half as many paths, and so on."""
        totals, ends = self.totals, [self.blocks]
        while len(ends) < self.max_looks and 2 * totals[0] <= totals[ends[-1] - 1]:
            ends.append(bisect_right(totals, totals[ends[-1] - 1] / 2))
        return tuple(reversed(ends))

    @property
    def extremes(self) -> int:
        """How many of the largest errors tell of tails: the square root of the number of paths."""
        return isqrt(self.paths - 1) + 1

    @property
    def level(self) -> float:
        """Significance level of one one-sided test at one look."""
        return (1.0 - self.confidence) / (self.tests_reserved * len(self.ends))

    def paths_of(self, block: int) -> int:
        """Return the number of paths of a block that are used."""
        return self.totals[block] - (self.totals[block - 1] if block else 0)


def read_levels(name: str, text: str) -> tuple[int, int]:
    """Return the coarsest number of steps and the number of levels.

    Parameters
    ----------
    name : str
        Of the argument, for the message.
    text : str
        ``COARSEST..FINEST`` with FINEST = COARSEST 2^k.

    Raises
    ------
    UsageError
        If it is not.
    """
    match = _RANGE.fullmatch(text)
    coarsest, finest = (int(steps) for steps in match.groups()) if match else (0, 0)
    doublings = finest // coarsest if coarsest else 0
    if doublings < 1 or coarsest * doublings != finest or doublings.bit_count() > 1:
        steps = Settings().steps
        expected = f"a number of levels or COARSEST..FINEST steps such as {steps[0]}..{steps[-1]}"
        raise UsageError(
            f"{name} expects {expected}, the finest being the coarsest times a power of 2, got {text!r:.200}"
        )
    return coarsest, doublings.bit_length()


def whole(name: str, value: object) -> int:
    """Return a whole number, of whatever type it is given as.

    Raises
    ------
    UsageError
        If it is none.
    """
    try:
        given = index(value)  # type: ignore[arg-type] # that is the question
    except TypeError:
        given = None
    if given is None or isinstance(value, bool):
        raise UsageError(f"{name} must be a whole number, got {value!r:.200}")
    return given


def number(name: str, value: object) -> float:
    """Return a real number; see `whole`."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise UsageError(f"{name} must be a number, got {value!r:.200}")
    return float(value)


def require(condition: bool, name: str, expected: str, given: object) -> None:
    """Refuse a number or word that is not as it must be.

    Parameters
    ----------
    condition : bool
        Whether it is.
    name, expected : str
    given : object

    Raises
    ------
    UsageError
    """
    if not condition:
        raise UsageError(f"{name} must be {expected}, got {given}")


class SettingsOptions(TypedDict, total=False):
    """Keywords of `Settings`."""

    paths: int
    coarsest: int
    levels: int | str
    first_levels: int
    seed: int
    confidence: float
    block: int
    max_looks: int
    tests_reserved: int


def settings_from(**settings: Unpack[SettingsOptions]) -> Settings:
    """Return settings from keywords.

    Raises
    ------
    UsageError
        If a keyword is unknown or a value out of its range.
    """
    known = SettingsOptions.__annotations__
    if unknown := sorted(set(settings) - set(known)):
        raise UsageError(f"unknown setting {', '.join(unknown)}; known are {', '.join(known)}")
    given: dict[str, Any] = dict(settings)
    if isinstance(levels := given.get("levels"), str):
        coarsest, given["levels"] = read_levels("levels", levels)
        if given.setdefault("coarsest", coarsest) != coarsest:
            raise UsageError(f"levels begin with {coarsest} steps, but coarsest is {given['coarsest']!r:.200}")
    if "levels" in given:
        # Who says which levels wants to see them.
        given.setdefault("first_levels", given["levels"])
    return Settings(**given)
