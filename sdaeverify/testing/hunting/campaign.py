"""All searches of a hunt, in shares on any workers; the same shares count regardless of workers and timing."""

import json
import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from math import isfinite
from typing import Any, NamedTuple

import hypothesis
from hypothesis import strategies as st

from ...contracts.specs import ProblemSpec
from ...simulate.ensemble import Marker
from ...store.code import arithmetic, code_of, framework_code
from ...workers.calls import call_anywhere, pickle_argument
from ...workers.executors import Workers
from ...workers.pool import BLOCKS_A_WORKER, in_turn
from ..strategies import EXAMPLES as DRAWINGS
from ..strategies import Example, shipped
from ..strategies.shipped import SHIPPED
from .options import HuntOptions
from .pilot import PARTS, place
from .search import Search, find, share_of
from .share import SIZE, Budget, Kept, Share, merged
from .sight import Target


@dataclass(frozen=True)
class Quarry:
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
    kept : Kept
    """

    target: Target
    when: tuple[str, ...]
    specs: tuple[ProblemSpec, ...]
    examples: int | None
    seconds: float
    shrinking: float
    seed: int
    kept: Kept

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
            remembered = () if number else tuple(self.kept.remembered())
            yield HuntShare(self.target, self.when, self.specs, budget, f"{self.seed} {number}", number, remembered)


class HuntShare(NamedTuple):
    """A share of a search, as it is sent to a worker."""

    target: Target
    when: tuple[str, ...]
    specs: tuple[ProblemSpec, ...]
    budget: Budget
    seed: str
    number: int
    remembered: tuple[Example, ...]


def search_all(quarries: Sequence[Quarry], crew: Workers, tell: Callable[[str], object]) -> list[Share]:
    """Return the result of the search for each claim.

    Shares are searched in parallel and counted in order, up to the first that finds a counterexample. The result
    depends neither on the number of workers nor on their speed. Shares of an interrupted hunt are read from its
    folder.

    Parameters
    ----------
    quarries : sequence of Quarry
    crew : Workers
    tell : callable
        Called with a line of text for each share.
    """
    met = [quarry.kept.read() for quarry in quarries]
    # A share carries the remaining time at which it was queued, so that shares must not wait under a time limit.
    queued = crew.jobs if any(isfinite(quarry.seconds) for quarry in quarries) else BLOCKS_A_WORKER * crew.jobs

    def calls() -> Iterator[tuple[tuple[int, int], Callable[[], Any]]]:
        for which, quarry in enumerate(quarries):
            for task in quarry.tasks(len(met[which])):
                if _is_over(met[which]):
                    break
                yield (which, task.number), _call(crew, task)

    for (which, number), answer in in_turn(crew.executor, queued, calls()):
        if not _is_over(met[which]):
            share = answer if crew.executor is None else pickle.loads(answer)
            met[which].append(share)
            quarries[which].kept.write(number, share)
            tell(_told(quarries[which], merged(met[which])))
    return [merged(shares or [Share(late=True)]) for shares in met]


def _is_over(shares: Sequence[Share]) -> bool:
    return bool(shares) and shares[-1].is_last


def _told(quarry: Quarry, share: Share) -> str:
    outcome = "none refutes it" if share.example is None else f"example {share.found_after} refutes it"
    return f"{quarry.words}: {share.looked_at} examples, {outcome}"


def _call(crew: Workers, task: HuntShare) -> Callable[[], Any]:
    if crew.executor is None:
        return partial(search_share, task)
    argument = pickle_argument(task, f"scheme {task.target.scheme.label}")
    return partial(call_anywhere, search_share, argument, crew.plugins)


def search_share(task: HuntShare, _: Marker | None = None) -> Share:
    """Search one share for a counterexample.

    Parameters
    ----------
    task : HuntShare
    """
    search = Search(task.target, task.budget, frozenset(task.when))
    return share_of(search, find(search, strategy_of(task), task.seed, task.remembered))


def strategy_of(task: HuntShare) -> st.SearchStrategy[Example]:
    """Return the strategy of a share: examples from their own start, or from a later state of the scheme.

    Parameters
    ----------
    task : HuntShare
    """
    if task.target.form == SHIPPED:
        return shipped(task.specs)
    drawing, wanted = DRAWINGS[task.target.form], set(task.when)
    # Use kinds that have the traits by construction; traits set by the form are found among all kinds.
    kinds = tuple(kind for kind in drawing.kinds if wanted <= set(drawing.traits.get(kind, ()))) or drawing.kinds
    return st.builds(partial(place, task.target.scheme), drawing.strategy(kinds=kinds), st.sampled_from(PARTS))


def made_with(target: Target, asked: HuntOptions) -> str:
    """Return all inputs of a share other than its claim, as text; empty if code has no source."""
    scheme, measure = code_of(type(target.scheme)), code_of(type(target.measure))
    if scheme is None or measure is None:
        return ""
    options = {name: getattr(asked, name) for name in ("examples", "shrinking", "seed")} | {
        "when": sorted(asked.when)
    }
    libraries = sorted({*arithmetic(), *scheme.libraries, *measure.libraries, f"hypothesis {hypothesis.__version__}"})
    return json.dumps([options, scheme.digest, measure.digest, framework_code(), libraries])
