"""Options of a hunt."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from sdaeverify import Scheme, Settings, UsageError
from sdaeverify.measuring import Measure

Schemes = str | Scheme | Sequence[str | Scheme]
Measures = str | Measure | Sequence[str | Measure]
EXAMPLES, SHRINKING = 200, 60.0


@dataclass(frozen=True, kw_only=True)
class HuntOptions:
    """Targets and budget of a hunt.

    Attributes
    ----------
    measures : str, Measure or sequence of them
        Measures whose claims are attacked; if empty, all claimed ones.
    when : sequence of str
        Required traits of the examples.
    forms : sequence of str
        Forms of the examples; if empty, those that a scheme solves directly. ``registered`` means registered problems
        with other numbers.
    examples : int or None
        Number of examples for each scheme, measure and form; 200 without `minutes`. An example drawn twice is
        examined and counted once.
    minutes : float or None
        Time of the whole search; counterexamples are shrunk and confirmed in addition.
    shrinking : float
        Seconds for shrinking a counterexample, at most the time of the search.
    seed : int
        The same seed gives the same result unless time ends the search.
    plugins : sequence of str or Path
        Plugin files.
    database : Path or None
        Folder that stores examined shares and counterexamples: an interrupted hunt continues with the same result,
        and the next hunt begins with the counterexamples.
    jobs : int or None
        Number of worker processes, or number of workers to assume for `executor`; None for all available cores.
    executor : Executor, str or None
        As in `verify`. It does not affect the result unless time ends the search.
    tell : callable
        Called with a line of text for progress.
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
    jobs: int | None = 1
    executor: Executor | str | None = None
    tell: Callable[[str], object] = str

    def __post_init__(self) -> None:
        Settings(seed=self.seed)  # which checks it
        for name in ("when", "forms"):
            if isinstance(given := getattr(self, name), str):
                raise UsageError(f"{name} expects a list of names, such as [{given!r:.200}], got {given!r:.200}")
        for name in ("examples", "jobs"):
            _require_count(name, getattr(self, name))
        if self.minutes is not None and not _number("minutes", self.minutes) > 0.0:
            raise UsageError(f"minutes must be positive, got {self.minutes!r:.200}")
        if not _number("shrinking", self.shrinking) >= 0.0:
            raise UsageError(f"shrinking must not be negative, got {self.shrinking!r:.200}")


def _require_count(name: str, value: object) -> None:
    if value is None:
        return
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise UsageError(f"{name} must be a whole number, got {value!r:.200}")
    if value < 1:
        raise UsageError(f"{name} must be at least 1, got {value}")


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise UsageError(f"{name} must be a number, got {value!r:.200}")
    return float(value)


def read_options(given: Mapping[str, Any]) -> HuntOptions:
    """Return hunt options from keyword arguments.

    Raises
    ------
    UsageError
        If a name is unknown or a value is out of its range.
    """
    if unknown := sorted(set(given) - set(HuntOptions.__annotations__)):
        known = ", ".join(HuntOptions.__annotations__)
        raise UsageError(f"unknown option {', '.join(unknown)} of a hunt; known are {known}")
    return HuntOptions(**given)
