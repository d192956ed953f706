"""Settings that determine the numbers of a run, in addition to the problem and the scheme."""

import re
from dataclasses import dataclass, fields
from math import isqrt
from numbers import Real
from operator import index
from typing import Any, TypedDict, Unpack

from ..errors import UsageError
from .stages import FEWEST_PATHS, FINEST_STEPS, LARGEST_BLOCK, MOST_PATHS, Stages

_RANGE = re.compile(r"([0-9]{1,9})\.\.([0-9]{1,9})")


@dataclass(frozen=True, kw_only=True)
class Settings(Stages):
    """Sample size, step sizes and level of confidence.

    Attributes
    ----------
    paths : int
        Maximum number M of paths of a cell.
    coarsest : int
        Steps N_0 of the coarsest level; errors are compared at its grid times.
    levels : int
        Number L of levels; level l makes N_0 2^l steps.
    first_levels : int
        Number of these levels, the coarsest ones, on which paths begin. They suffice to guard verdicts decided by one
        step; verdicts that rest on the paths themselves are run again on all levels.
    seed : int
    confidence : float
        Of the two-sided intervals on which verdicts are based.
    block : int
        Maximum number of paths simulated together; it affects the noise. The first block has 256 paths, the second
        768, the next as many as all before it, until this size is reached.
    max_looks : int
        Maximum number of times that a cell is judged, with at least twice the paths each time, until it is decided.
    tests_reserved : int
        Number of tests among which a run shares its error probability when it decides early: each look of each
        one-sided test has level (1 - confidence)/(tests_reserved max_looks).

    Raises
    ------
    UsageError
        If a value is out of its range.
    """

    seed: int = 20170601
    confidence: float = 0.99
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
            require(given >= 3, name, "at least 3, which a slope needs", given)
        require(self.steps[-1] <= FINEST_STEPS, "the finest number of steps", "at most 2^20", self.steps[-1])
        require(0 <= self.seed < 2**63, "seed", "between 0 and 2^63 - 1", self.seed)
        require(0.5 <= self.confidence < 1, "confidence", "between 0.5 and 1", self.confidence)
        require(1 <= self.max_looks <= 20, "max_looks", "between 1 and 20", self.max_looks)
        require(1 <= self.tests_reserved <= 10**9, "tests_reserved", "at least 1", self.tests_reserved)
        require(FEWEST_PATHS <= self.block <= LARGEST_BLOCK, "block", f"between {FEWEST_PATHS} and 2^20", self.block)

    @property
    def extremes(self) -> int:
        """Number of largest errors used to estimate tails: the square root of the number of paths, rounded up."""
        return isqrt(self.paths - 1) + 1

    @property
    def level(self) -> float:
        """Significance level of one one-sided test at one look."""
        return (1.0 - self.confidence) / (self.tests_reserved * len(self.ends))


def read_levels(name: str, text: str) -> tuple[int, int]:
    """Parse a range of step numbers into the coarsest number of steps and the number of levels.

    Parameters
    ----------
    name : str
        Of the argument, for the message.
    text : str
        ``COARSEST..FINEST`` with FINEST = COARSEST 2^k.

    Raises
    ------
    UsageError
        If the text is not of this form.
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
    """Convert a whole number of any integral type to int.

    Raises
    ------
    UsageError
        If the value is not a whole number.
    """
    try:
        given = index(value)  # type: ignore[arg-type] # the type is what this line checks
    except TypeError:
        given = None
    if given is None or isinstance(value, bool):
        raise UsageError(f"{name} must be a whole number, got {value!r:.200}")
    return given


def number(name: str, value: object) -> float:
    """Convert a real number to float.

    Raises
    ------
    UsageError
        If the value is not a real number.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise UsageError(f"{name} must be a number, got {value!r:.200}")
    return float(value)


def require(condition: bool, name: str, expected: str, given: object) -> None:
    """Raise if a number or word is not as expected.

    Parameters
    ----------
    condition : bool
        Whether the value is as expected.
    name, expected : str
    given : object

    Raises
    ------
    UsageError
        If `condition` is false.
    """
    if not condition:
        raise UsageError(f"{name} must be {expected}, got {given}")


class SettingsOptions(TypedDict, total=False):
    """Keyword arguments that `Settings` takes; `levels` may also be a range of step numbers."""

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
        # A user who chooses the levels expects all of them in the results.
        given.setdefault("first_levels", given["levels"])
    return Settings(**given)
