"""The search for a counterexample of one claim: drawn, climbed to, shrunk. It needs hypothesis."""

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import NamedTuple

import hypothesis
from hypothesis.database import DirectoryBasedExampleDatabase
from hypothesis.errors import NoSuchExample
from hypothesis.strategies import SearchStrategy

from ...contracts.measure import Measure
from ...contracts.scheme import Scheme
from ..strategies.example import Example, function_of
from .sight import Sight, look

# What `hypothesis` is told where time is what ends a search.
MOST = 10**6
# A distance from claim to order that is more than rounding: from here on the search climbs.
CLIMB = 0.02
# Examples none of which the claim is about, in a row, until there is thought to be none.
FUTILE = 400


class Budget(NamedTuple):
    """What a search may cost.

    Attributes
    ----------
    examples : int
        That are looked at.
    seconds : float
        Until the first one is found.
    shrinking : float
        Seconds from then on.
    """

    examples: int = 200
    seconds: float = float("inf")
    shrinking: float = 60.0


class Target(NamedTuple):
    """What is attacked.

    Attributes
    ----------
    scheme : Scheme
    measure : Measure
    form : str
        Of the examples.
    """

    scheme: Scheme
    measure: Measure
    form: str


class _OverError(BaseException):
    """The budget is spent before anything was found."""


@dataclass
class Search:
    """One search, and what it has met.

    Attributes
    ----------
    target : Target
    budget : Budget
    wanted : frozenset of str
        Traits that a problem must have.
    seen : dict
        What was seen of each example; None of those that the claim is not about.
    tried : Counter
        How many examples were looked at, by kind and class.
    first : Example or None
        The first counterexample, before it is shrunk.
    found_after, seconds : int, float
        Examples and time until then.
    verified : int
        Number of examples on which what was looked at verifies the claim; what it does not decide is left over.
    doubtful : int
        How many refuted the claim, but not again from another start or with larger coefficients.
    """

    target: Target
    budget: Budget
    wanted: frozenset[str] = frozenset()
    seen: dict[Example, Sight | None] = field(default_factory=dict)
    tried: Counter[tuple[str, str]] = field(default_factory=Counter)
    first: Example | None = None
    found_after: int = 0
    seconds: float = 0.0
    verified: int = 0
    doubtful: int = 0
    begun: float = field(default_factory=time.monotonic)

    @property
    def looked_at(self) -> int:
        """Number of examples that the claim is about."""
        return sum(self.tried.values())

    def refutes(self, example: Example) -> bool:
        """Tell whether an example refutes the claim."""
        if example not in self.seen:
            if self._spent():
                return False
            self.seen[example] = self._look(example)
        sight = self.seen[example]
        if sight is None:
            hypothesis.reject()
        if sight.distance > CLIMB:
            hypothesis.target(sight.distance)
        return bool(sight.refuted)

    def _spent(self) -> bool:
        passed = time.monotonic() - self.begun
        if self.first is not None:
            return passed - self.seconds > self.budget.shrinking
        futile = not self.tried and len(self.seen) >= FUTILE
        if self.looked_at >= self.budget.examples or passed > self.budget.seconds or futile:
            raise _OverError
        return False

    def _look(self, example: Example) -> Sight | None:
        sight = self._sight(example)
        if sight is None:
            return None
        self.tried[example.kind, example.group] += 1
        if not sight.refuted:
            self.verified += sight.verified
            return sight
        if self.first is None:
            if not self.is_refuted_again(example):
                self.doubtful += 1
                return sight._replace(refuted="")
            self.first, self.found_after, self.seconds = example, self.looked_at, time.monotonic() - self.begun
        return sight

    def is_refuted_again(self, example: Example) -> bool:
        """Tell whether an example refutes the claim from another start, and with coefficients twice as large, too."""
        again = example.moved(), example.doubled(), example.moved().doubled()
        return all(sight is not None and sight.refuted for sight in map(self._sight, again))

    def _sight(self, example: Example) -> Sight | None:
        function = function_of(example.source)
        if self.wanted and not _has(function, self.target.scheme, self.wanted):
            return None
        return look(self.target.scheme, function, self.target.measure)


def _has(function: Callable[[], object], scheme: Scheme, wanted: frozenset[str]) -> bool:
    view = scheme.view_of(function())  # type: ignore[arg-type]
    return view is not None and wanted <= view.traits


def any_of(strategy: SearchStrategy[Example]) -> Example:
    """Return an example, the same each time."""
    settings = hypothesis.settings(database=None, phases=[hypothesis.Phase.generate])
    return hypothesis.find(strategy, lambda _: True, settings=settings, random=Random(0))


def find(search: Search, strategy: SearchStrategy[Example], seed: int, database: Path | None) -> Example | None:
    """Return the smallest counterexample that a search comes to and that is refuted again, or None.

    Parameters
    ----------
    search : Search
        It notes what it meets.
    strategy : SearchStrategy
        What is drawn from.
    seed : int
        The same seed gives the same example, where no time limit ends the search.
    database : Path or None
        A folder in which hypothesis keeps what refuted a claim: it is tried first the next time.
    """
    kept = None if database is None else DirectoryBasedExampleDatabase(database)
    settings = hypothesis.settings(
        max_examples=min(search.budget.examples, MOST),
        deadline=None,
        database=kept,
        verbosity=hypothesis.Verbosity.quiet,
    )
    key = " ".join((search.target.scheme.label, search.target.measure.name, search.target.form)).encode()
    try:
        found = hypothesis.find(strategy, search.refutes, settings=settings, random=Random(seed), database_key=key)
        return found if search.is_refuted_again(found) else search.first
    except (NoSuchExample, _OverError, hypothesis.errors.Unsatisfiable):
        return None
