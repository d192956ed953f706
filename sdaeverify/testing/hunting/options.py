"""What a hunt looks for, and how long."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...api import Measures
from ...contracts.settings import number, require, whole
from ...errors import UsageError

EXAMPLES, SHRINKING = 200, 60.0


@dataclass(frozen=True, kw_only=True)
class HuntOptions:
    """What a hunt looks for, and how long.

    Attributes
    ----------
    measures : str, Measure or sequence of them
        Whose claims are attacked; all that the schemes claim where empty.
    when : sequence of str
        Traits that each example has.
    forms : sequence of str
        Of the examples; those that a scheme solves itself where empty. ``registered`` are the registered problems
        with other numbers.
    examples : int or None
        How many are drawn for each scheme, measure and form; 200 without `minutes`. One that is drawn twice is
        looked at, and counted, once.
    minutes : float or None
        For the search of all of them together; what is found is shrunk and confirmed on top.
    shrinking : float
        Seconds that a counterexample is shrunk, at most as long as it may be looked for.
    seed : int
        The same seed finds the same, where no time ends the search.
    plugins : sequence of str or Path
        Plugin files.
    database : Path or None
        A folder that remembers what was looked at: a hunt that was interrupted goes on, and gives what it would have
        given; and what refuted a claim: the next hunt begins with it.
    jobs : int
        Worker processes; of an executor that is given, how many workers it has.
    executor : Executor, str or None
        As `verify` takes it. The result is the same, where no time ends the search.
    tell : callable
        It is given a line of text now and then.
    """

    measures: Measures = ()
    when: Sequence[str] = ()
    forms: Sequence[str] = ()
    examples: int | None = None
    minutes: float | None = None
    shrinking: float = SHRINKING
    seed: int = 1
    plugins: Sequence[str | Path] = ()
    database: str | Path | None = None
    jobs: int = 1
    executor: Executor | str | None = None
    tell: Callable[[str], object] = str

    def __post_init__(self) -> None:
        require(0 <= whole("seed", self.seed) < 2**63, "seed", "between 0 and 2^63 - 1", self.seed)
        for name in ("when", "forms"):
            if isinstance(given := getattr(self, name), str):
                raise UsageError(f"{name} expects a list of names, such as [{given!r:.200}], got {given!r:.200}")
        if self.examples is not None and whole("examples", self.examples) < 1:
            raise UsageError(f"examples must be at least 1, got {self.examples}")
        if whole("jobs", self.jobs) < 1:
            raise UsageError(f"jobs must be at least 1, got {self.jobs}")
        if self.minutes is not None and not number("minutes", self.minutes) > 0.0:
            raise UsageError(f"minutes must be positive, got {self.minutes!r:.200}")
        if not number("shrinking", self.shrinking) >= 0.0:
            raise UsageError(f"shrinking must not be negative, got {self.shrinking!r:.200}")


def read_options(given: Mapping[str, Any]) -> HuntOptions:
    """Return options that an author gives by name.

    Raises
    ------
    UsageError
        If a name is unknown or a value out of its range.
    """
    if unknown := sorted(set(given) - set(HuntOptions.__annotations__)):
        known = ", ".join(HuntOptions.__annotations__)
        raise UsageError(f"unknown option {', '.join(unknown)} of a hunt; known are {known}")
    return HuntOptions(**given)
