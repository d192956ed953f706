"""How much work a study has left, from the measured seconds of what is done."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import isnan, nan
from statistics import fmean

from ..contracts.settings import Settings
from ..simulate.reference import OWN_REFERENCE
from .plan import ProblemPlan

# Until a further look was measured, a path of it is taken for so much of one of the first, which includes probing.
FURTHER = 0.25
# As many schemes as what they took without paths counts for, beside those that were measured on paths.
PRIOR = 2.0


@dataclass
class Looks:
    """Problems that were judged, and those of them that go on."""

    judged: int = 0
    again: int = 0

    @property
    def share(self) -> float:
        """Part of them that goes on."""
        return self.again / self.judged if self.judged else 0.0


@dataclass
class Forecast:
    """Seconds of work that are left, those of all workers together.

    The first look at a problem costs what its schemes have cost so far and, as long as these are few, what schemes
    that took as long without paths have cost on other problems; a further look costs what its paths have cost; and as
    many problems are looked at again as were so far.

    Parameters
    ----------
    schemes : mapping of str to int
        Number of schemes of each problem that is open, by its label.
    first : int
        Paths of the first look.

    Attributes
    ----------
    screened, done, further : dict of str to list of float
        Measured seconds of each scheme without paths, at the first look, and of a scheme and path at further ones, by
        problem.
    over : set of str
        Problems whose first look is over.
    first_looks, further_looks : Looks
    spent : float
        All seconds measured.
    """

    schemes: Mapping[str, int]
    first: int
    screened: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    done: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    further: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    over: set[str] = field(default_factory=set)
    first_looks: Looks = field(default_factory=Looks)
    further_looks: Looks = field(default_factory=Looks)
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
            self.further[problem].append(seconds / (schemes * paths))

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

    def left(self, queued: Iterable[tuple[str, int, int]]) -> float:
        """Return the seconds that are left.

        Parameters
        ----------
        queued : iterable of (str, int, int)
            Problem, schemes and paths of each block of a further look that is known to be wanted.
        """
        pace = self._pace
        waiting = {name: count for name, count in self.schemes.items() if name not in self.over}
        left = {name: count - len(self.screened[name]) for name, count in self.schemes.items()}
        screening = sum(max(0, count) * _mean(self.screened, name) for name, count in left.items())
        first = sum(max(0, count - len(self.done[name])) * self._first(name, pace) for name, count in waiting.items())
        further = sum(schemes * paths * self._path(name, pace) for name, schemes, paths in queued)
        expected = sum(count * self.first * self._path(name, pace) for name, count in waiting.items())
        # A look has as many paths as all before it: what follows one costs twice as much.
        return (
            screening + first + further * (1.0 + 2.0 * self.further_looks.share) + self.first_looks.share * expected
        )

    @property
    def _pace(self) -> float:
        """Seconds of a first look for each second without paths, of schemes that have had both; NaN for none."""
        both = [name for name, seconds in self.done.items() if seconds and self.screened[name]]
        without = sum(len(self.done[name]) * fmean(self.screened[name]) for name in both)
        return sum(sum(self.done[name]) for name in both) / without if without else nan

    def _first(self, problem: str, pace: float) -> float:
        done, screened = self.done[problem], self.screened[problem]
        if isnan(pace) or not screened:
            return _mean(self.done, problem)
        return (sum(done) + PRIOR * pace * fmean(screened)) / (len(done) + PRIOR)

    def _path(self, problem: str, pace: float) -> float:
        if self.further[problem]:
            return fmean(self.further[problem])
        return FURTHER * self._first(problem, pace) / self.first


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
