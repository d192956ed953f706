"""Search for a counterexample to one claim: random draws, hill climbing, shrinking. Requires hypothesis."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random

import hypothesis
from hypothesis.errors import NoSuchExample
from hypothesis.strategies import SearchStrategy

from sdaeverify import Scheme

from .observation import WAYS, Observation, Target, observe
from .share import Budget, Share
from .strategies.example import Example, function_of

# Without the phase "explain", for which hypothesis draws many examples after shrinking, and prints.
PHASES = (hypothesis.Phase.generate, hypothesis.Phase.target, hypothesis.Phase.shrink)
# Consecutive examples outside the scope of the claim after which the search gives up.
FUTILE = 400


class _OverError(BaseException):
    """The budget was spent before a counterexample was found."""


@dataclass
class Search:
    """A search and its statistics.

    Attributes
    ----------
    target : Target
    budget : Budget
    wanted : frozenset of str
        Required traits of a problem.
    seen : dict
        Observations by example; None for an example outside the scope of the claim.
    tried : Counter
        Number of examined examples, by kind and class.
    claims : Counter
        Number of examples in the scope of each claim.
    first : Example or None
        First counterexample, before shrinking.
    smallest : Example or None
        First counterexample without the terms that it does not need.
    way : str
        Way in which it was refuted, the only one tried for smaller examples.
    found_after, seconds : int, float
        Number of examples and seconds until the first counterexample.
    verified : int
        Number of examples that verify the claim.
    doubtful : int
        Number of examples that refuted the claim, but not again from another start or with larger coefficients.
    late : bool
        Whether a time limit ended the search.
    """

    target: Target
    budget: Budget
    wanted: frozenset[str] = frozenset()
    seen: dict[Example, Observation | None] = field(default_factory=dict)
    tried: Counter[tuple[str, str]] = field(default_factory=Counter)
    claims: Counter[str] = field(default_factory=Counter)
    first: Example | None = None
    smallest: Example | None = None
    way: str = ""
    found_after: int = 0
    seconds: float = 0.0
    verified: int = 0
    doubtful: int = 0
    late: bool = False
    begun: float = field(default_factory=time.monotonic)

    @property
    def looked_at(self) -> int:
        """Number of examples in the scope of the claim."""
        return sum(self.tried.values())

    def refutes(self, example: Example) -> bool:
        """Return whether an example refutes the claim, and report its distance as a target to hypothesis."""
        if example not in self.seen and self._spent():
            return False
        seen = self.observation(example)
        if seen is None:
            hypothesis.reject()
        for name, value in seen.goals.items():
            hypothesis.target(value, label=name)
        return bool(seen.refuted)

    def observation(self, example: Example) -> Observation | None:
        """Return the observation of an example, computed once."""
        if example not in self.seen:
            self.seen[example] = self._look(example)
        return self.seen[example]

    def _spent(self) -> bool:
        passed = time.monotonic() - self.begun
        if self.first is not None:
            return passed - self.seconds > self.budget.shrinking
        futile = not self.tried and len(self.seen) >= FUTILE
        self.late = passed > self.budget.seconds
        if self.looked_at >= self.budget.examples or self.late or futile:
            raise _OverError
        return False

    def _look(self, example: Example) -> Observation | None:
        seen = self._observe(example)
        if seen is None:
            return None
        self.tried[example.kind, example.group] += 1
        self.claims.update(seen.claims)
        if not seen.refuted:
            self.verified += seen.verified
            return seen
        if self.first is None:
            self.way = seen.way
            if not self.is_refuted_again(example):
                self.doubtful, self.way = self.doubtful + 1, ""
                return seen._replace(refuted="")
            self.first, self.found_after, self.seconds = example, self.looked_at, time.monotonic() - self.begun
            self.smallest = self._without_terms(example)
        return seen

    def _without_terms(self, example: Example) -> Example:
        """Return an example without the terms that it does not need to refute the claim.

        This takes at most half of the time for shrinking. hypothesis shrinks a sequence of choices by small steps,
        each of which needs an examination of about a second.
        """
        smallest, end = example, time.monotonic() + 0.5 * self.budget.shrinking
        for terms in example.simpler():
            fewer = smallest.dropped(terms)
            if fewer == smallest:
                continue
            if time.monotonic() > end:
                break
            if (seen := self.observation(fewer)) is not None and seen.refuted:
                smallest = fewer
        return smallest

    def is_refuted_again(self, example: Example) -> bool:
        """Return whether an example refutes the claim also from another start and with doubled coefficients."""
        again = example.moved(), example.doubled(), example.moved().doubled()
        return all(seen is not None and seen.refuted for seen in map(self._observe, again))

    def _observe(self, example: Example) -> Observation | None:
        function = function_of(example.source)
        if self.wanted and not _has(function, self.target.scheme, self.wanted):
            return None
        return observe(self.target, function, (self.way,) if self.way else WAYS)


def _has(function: Callable[[], object], scheme: Scheme, wanted: frozenset[str]) -> bool:
    view = scheme.view_of(function())  # type: ignore[arg-type]
    return view is not None and wanted <= view.traits


def any_of(strategy: SearchStrategy[Example]) -> Example:
    """Return an example of a strategy, always the same."""
    settings = hypothesis.settings(database=None, phases=[hypothesis.Phase.generate])
    return hypothesis.find(strategy, lambda _: True, settings=settings, random=Random(0))


def find(
    search: Search, strategy: SearchStrategy[Example], seed: str, remembered: Sequence[Example] = ()
) -> Example | None:
    """Return the smallest counterexample that is refuted again, or None.

    Parameters
    ----------
    search : Search
        Search whose statistics are updated.
    strategy : SearchStrategy
        Strategy of the examples.
    seed : str
        The same seed gives the same example unless a time limit ends the search.
    remembered : sequence of Example
        Examples that refuted the claim earlier, which are tried first.
    """
    known = (example for example in remembered if (seen := search.observation(example)) is not None and seen.refuted)
    if (example := next(known, None)) is not None:
        return example
    settings = hypothesis.settings(
        max_examples=search.budget.examples,
        deadline=None,
        database=None,
        phases=PHASES,
        verbosity=hypothesis.Verbosity.quiet,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    try:
        found = hypothesis.find(strategy, search.refutes, settings=settings, random=Random(seed))
        both = sorted((found, search.smallest or found), key=size)
        return next((each for each in both if search.is_refuted_again(each)), search.first)
    except (NoSuchExample, _OverError, hypothesis.errors.Unsatisfiable):
        return None


def size(example: Example) -> tuple[int, int, int]:
    """Return the size of an example: terms of its longest coefficient, components, and terms of all coefficients."""
    return example.longest, example.dimension, example.terms


def share_of(search: Search, example: Example | None) -> Share:
    """Return the result of a search.

    Parameters
    ----------
    search : Search
        Completed search.
    example : Example or None
        Counterexample, if any.
    """
    seen = None if example is None else search.seen[example]
    return Share(
        example,
        "" if seen is None else seen.claim,
        "" if seen is None else seen.refuted,
        tuple((*place, count) for place, count in sorted(search.tried.items())),
        search.verified,
        search.doubtful,
        search.found_after,
        search.seconds if search.first is not None else time.monotonic() - search.begun,
        search.late,
        tuple(sorted(search.claims.items())),
    )
