"""All searches of a hunt, in shares on any workers; the same shares count regardless of workers and timing."""

import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from math import isfinite
from typing import NamedTuple

import hypothesis
from hypothesis import strategies as st

from sdaeverify.studying import ProblemSpec, Registry, call_in_turn, code_key

from .observation import Target
from .options import HuntOptions
from .pilot import PARTS, place
from .search import Search, find, share_of
from .share import SIZE, Budget, Share, StoredShares, merged
from .strategies import EXAMPLES as DRAWINGS
from .strategies import STATIONARY, Example, shipped
from .strategies.shipped import SHIPPED


@dataclass(frozen=True, eq=False)
class ClaimSearch:
    """A claim under attack, and the budget of the attack.

    Attributes
    ----------
    target : Target
    when : tuple of str
        Traits that each example has.
    specs : tuple of ProblemSpec
        Registered problems, if they are the examples.
    examples : int or None
        Number of examples; None for as many as time allows.
    seconds, shrinking : float
    seed : int
    stored : StoredShares
    """

    target: Target
    when: tuple[str, ...]
    specs: tuple[ProblemSpec, ...]
    examples: int | None
    seconds: float
    shrinking: float
    seed: int
    stored: StoredShares

    @property
    def words(self) -> str:
        """Scheme, measure and form in words."""
        return f"{self.target.scheme.label}, {self.target.measure.name}, {self.target.form}"

    def tasks(self, first: int) -> Iterator["HuntShare"]:
        """Yield the shares from number `first` on, while time and examples remain."""
        end = time.monotonic() + self.seconds
        for number in count(first):
            size = SIZE if self.examples is None else min(SIZE, self.examples - number * SIZE)
            left = end - time.monotonic()
            if size <= 0 or left <= 0.0:
                return
            budget = Budget(size, left, min(self.shrinking, self.seconds))
            remembered = () if number else tuple(self.stored.remembered())
            yield HuntShare(self, budget, number, remembered)


class HuntShare(NamedTuple):
    """A share of a search, as it is sent to a worker."""

    search: ClaimSearch
    budget: Budget
    number: int
    remembered: tuple[Example, ...]


def search_all(searches: Sequence[ClaimSearch], registry: Registry, asked: HuntOptions) -> list[Share]:
    """Return the result of the search for each claim.

    Shares are searched in parallel and counted in order, up to the first that finds a counterexample. The result
    depends neither on the number of workers nor on their speed. Shares of an interrupted hunt are read from its
    folder.

    Parameters
    ----------
    searches : sequence of ClaimSearch
    registry : Registry
    asked : HuntOptions
        With the workers, and a function that is called with a line of text for each share.
    """
    found = {search: search.stored.read() for search in searches}

    def tasks() -> Iterator[tuple[str, HuntShare]]:
        for search in searches:
            for task in search.tasks(len(found[search])):
                if _is_over(found[search]):
                    break
                yield f"scheme {search.target.scheme.label}", task

    # A share carries the remaining time at which it was queued, so that shares must not wait under a time limit.
    ahead = {"ahead": 1} if any(isfinite(search.seconds) for search in searches) else {}
    for task, share in call_in_turn(search_share, tasks(), registry, asked.jobs, asked.executor, **ahead):
        shares = found[task.search]
        if not _is_over(shares):
            shares.append(share)
            task.search.stored.write(task.number, share)
            asked.tell(_told(task.search, merged(shares)))
    return [merged(shares or [Share(late=True)]) for shares in found.values()]


def _is_over(shares: Sequence[Share]) -> bool:
    return bool(shares) and shares[-1].is_last


def _told(search: ClaimSearch, share: Share) -> str:
    outcome = "none refutes it" if share.example is None else f"example {share.found_after} refutes it"
    return f"{search.words}: {share.looked_at} examples, {outcome}"


def search_share(task: HuntShare) -> Share:
    """Search one share for a counterexample.

    Parameters
    ----------
    task : HuntShare
    """
    asked = task.search
    search = Search(asked.target, task.budget, frozenset(asked.when))
    return share_of(search, find(search, strategy_of(asked), f"{asked.seed} {task.number}", task.remembered))


def strategy_of(asked: ClaimSearch) -> st.SearchStrategy[Example]:
    """Return the strategy of a search: examples from their own start, or from a later state of the scheme.

    Parameters
    ----------
    asked : ClaimSearch
    """
    if asked.target.form == SHIPPED:
        return shipped(asked.specs)
    drawing, wanted = (DRAWINGS | STATIONARY)[asked.target.form], set(asked.when)
    # Use kinds that have the traits by construction; traits set by the form are found among all kinds.
    kinds = tuple(kind for kind in drawing.kinds if wanted <= set(drawing.traits.get(kind, ()))) or drawing.kinds
    return st.builds(partial(place, asked.target.scheme), drawing.strategy(kinds=kinds), st.sampled_from(PARTS))


def made_with(target: Target, asked: HuntOptions) -> str:
    """Return a hash of all inputs of a share other than its claim; empty if code has no source."""
    options = {name: getattr(asked, name) for name in ("examples", "shrinking", "seed")}
    given = json.dumps([options, sorted(asked.when), f"hypothesis {hypothesis.__version__}"])
    return code_key(type(target.scheme), type(target.measure), HuntOptions, of=given)
