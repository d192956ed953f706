"""How much work a study has left, from the measured seconds of what is done."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean
from typing import NamedTuple

from ..contracts.settings import Settings
from ..simulate.reference import OWN_REFERENCE
from .plan import ProblemPlan

# Seconds of the first paths for each second without paths; and, of a scheme and a path, the part of them that a path
# of the next look takes, and one of each look after it of those of the one before: calls weigh less with more paths.
FIRST, NEXT, LATER = 0.5, 0.8, 0.55
# Share of the problems that are looked at again after the first look, and after further ones.
AGAIN, ONCE_MORE = 0.7, 0.6
# As many problems, or schemes of a problem, as these guesses count for beside those that were measured.
PRIOR = 8.0
# As many schemes as what they took without paths counts for, beside those that were measured on paths.
ALIKE = 2.0


@dataclass
class Looks:
    """Problems that were judged, and those of them that go on; at first as many as a guess counts for.

    Parameters
    ----------
    guess : float
        Share of the problems that go on.
    """

    guess: float
    judged: float = PRIOR
    again: float = 0.0

    def __post_init__(self) -> None:
        self.again = self.guess * self.judged

    @property
    def share(self) -> float:
        """Part of them that goes on."""
        return self.again / self.judged


class Queued(NamedTuple):
    """A block that is wanted: its problem, schemes, paths, and the number of its look."""

    problem: str
    schemes: int
    paths: int
    look: int


class _Look(NamedTuple):
    """Measured seconds of so many schemes on so many paths."""

    paths: int
    seconds: float = 0.0
    schemes: int = 0


@dataclass
class Forecast:
    """Seconds of work that are left, those of all workers together.

    What is found without paths costs what it has cost of the schemes of a problem so far; the first look what its
    schemes have cost and, as long as these are few, what schemes that took as long without paths have cost on other
    problems; a further look what its paths have cost before. As many problems go on as did so far. Where nothing was
    measured yet, there are guesses, which count for a few measurements.

    Parameters
    ----------
    schemes : mapping of str to int
        Number of schemes of each problem that is open, by its label.
    looks : sequence of int
        Paths of the first block, and those that each further look adds.

    Attributes
    ----------
    screened, done : dict of str to list of float
        Measured seconds of each scheme without paths and at the first look, by problem.
    further : dict of str to _Look
        What the last further look took, by problem.
    over : set of str
        Problems whose first look is over.
    first_looks, further_looks : Looks
    spent : float
        All seconds measured.
    """

    schemes: Mapping[str, int]
    looks: Sequence[int]
    screened: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    done: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    further: "dict[str, _Look]" = field(default_factory=dict)
    over: set[str] = field(default_factory=set)
    first_looks: Looks = field(default_factory=lambda: Looks(AGAIN))
    further_looks: Looks = field(default_factory=lambda: Looks(ONCE_MORE))
    spent: float = 0.0

    def heard(self, problem: str, seconds: float, schemes: int, paths: int | None) -> None:
        """Take note of what some schemes took on a problem; `paths` is None for the first look.

        Parameters
        ----------
        problem : str
            Label.
        seconds : float
            Measured, of one worker.
        schemes : int
            How many were run together.
        paths : int or None
            On each; None for the first look, whose number of paths is everybody's.
        """
        self.spent += seconds
        if paths is None:
            self.done[problem] += [seconds / schemes] * schemes
        else:
            known = self.further.get(problem, _Look(paths))
            before = known if known.paths == paths else _Look(paths)
            self.further[problem] = _Look(paths, before.seconds + seconds, before.schemes + schemes)

    def heard_screening(self, problem: str, seconds: float, schemes: int) -> None:
        """Take note of what some schemes took on a problem without paths.

        Parameters
        ----------
        problem : str
            Label.
        seconds : float
            Measured, of one worker.
        schemes : int
            How many were screened together.
        """
        self.spent += seconds
        self.screened[problem] += [seconds / schemes] * schemes

    def looked(self, *, first: bool, goes_on: bool) -> None:
        """Take note that a problem was judged, and whether it is looked at again."""
        looks = self.first_looks if first else self.further_looks
        looks.judged, looks.again = looks.judged + 1, looks.again + goes_on

    def left(self, queued: "Iterable[Queued]") -> float:
        """Return the seconds that are left.

        Parameters
        ----------
        queued : iterable of Queued
            Blocks after the first one that are known to be wanted.
        """
        open_schemes = ((name, n - len(self.screened[name])) for name, n in self.schemes.items())
        screening = sum(max(0, count) * self._screening(name) for name, count in open_schemes)
        ratio = self._first_seconds
        first, expected = 0.0, 0.0
        for name in (name for name in self.schemes if name not in self.over):
            each = self._first(name, ratio)
            first += max(0, self.schemes[name] - len(self.done[name])) * each
            expected += self.schemes[name] * each * self._next
        further = sum(one.schemes * self._block(one, ratio) * self._followed(one.look) for one in queued)
        return screening + first + further + self.first_looks.share * expected

    def _screening(self, problem: str) -> float:
        return _mean(self.screened, problem)

    @property
    def _first_seconds(self) -> float:
        """Seconds of a first look for each second without paths, of schemes that have had both."""
        both = [name for name, seconds in self.done.items() if seconds and self.screened[name]]
        without = sum(len(self.done[name]) * fmean(self.screened[name]) for name in both)
        some = [sum(seconds) for seconds in self.screened.values() if seconds]
        guessed = PRIOR * fmean(some) if some else 0.0
        known = guessed + without
        return (FIRST * guessed + sum(sum(self.done[name]) for name in both)) / known if known else FIRST

    def _first(self, problem: str, ratio: float) -> float:
        """Return the seconds of a scheme at the first look."""
        done = self.done[problem]
        if not any(self.screened.values()):
            return _mean(self.done, problem)
        return (sum(done) + ALIKE * ratio * self._screening(problem)) / (len(done) + ALIKE)

    def _block(self, queued: "Queued", ratio: float) -> float:
        """Return the seconds of a scheme on a block."""
        known = self.further.get(queued.problem)
        if known is not None:
            later = LATER if known.paths < queued.paths else 1.0
            return known.seconds / (known.schemes * known.paths) * later * queued.paths
        return self._first(queued.problem, ratio) * NEXT * queued.paths / self.looks[0]

    @property
    def _next(self) -> float:
        """What the next look and all that may follow it cost, in multiples of the first block."""
        return NEXT * self.looks[1] / self.looks[0] * self._followed(1) if len(self.looks) > 1 else 0.0

    def _followed(self, look: int) -> float:
        """Return what a look and all that may follow it cost, in multiples of itself."""
        whole, cost = 1.0, 1.0
        for after in range(look + 1, len(self.looks)):
            cost *= self.further_looks.share * LATER * self.looks[after] / self.looks[after - 1]
            whole += cost
        return whole


def _mean(seconds: Mapping[str, list[float]], problem: str) -> float:
    """Return the mean of a problem, or of all others; 0 where nothing is known."""
    known = seconds[problem] or [each for those in seconds.values() for each in those]
    return fmean(known) if known else 0.0


def weight(plan: ProblemPlan, settings: Settings) -> int:
    """Return how much the first paths of a problem weigh beside those of others: steps of all its schemes.

    Steps on so few paths cost their calls, whatever the problem; a scheme that is its own truth makes most of them.
    """
    assert plan.problem is not None
    last = settings.levels - 1
    own = OWN_REFERENCE if plan.problem.pathwise is None else 0
    steps = sum(settings.steps) + (settings.coarsest << (last + own) if own else 0)
    return steps * len({cell.scheme for cell in (*plan.runnable, *plan.control_cells)})


def breadth(plan: ProblemPlan) -> int:
    """Return how much the screening of a problem weighs: cells, times the noises that nodes are of."""
    assert plan.problem is not None
    return len(plan.runnable) * (1 + plan.problem.noise_dim)
