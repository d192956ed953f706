"""How much work a study has left, from the measured seconds of what is done."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from statistics import fmean

from ..contracts.settings import SCREENING, Settings
from ..simulate.reference import OWN_REFERENCE
from .plan import ProblemPlan

# Guesses, the rounded means of default runs. Seconds of the first paths for each second without paths, and for how
# many schemes this counts beside those of a problem that were measured on paths.
FIRST, ALIKE = 0.4, 2.0
# What each time as many paths as in the first block add to the time of a block, as part of that of the first: the
# rest are its calls.
GROWTH = 0.08
# Part of the further looks at a problem that is taken, as long as its paths have not told anything yet.
AGAIN = 0.3

# A scheme, by its label, on a block of paths or, in place of them, without paths.
Piece = tuple[str, int]


@dataclass
class Forecast:
    """Seconds of work that are left, those of all workers together.

    A scheme costs without paths what others have cost on its problem; on its first paths, too, and, as long as these
    others are few, a part of what they took without paths; on further paths what its own have cost. Which further
    ones it takes is said by its findings, of how many paths would decide; until there are some, it is a guess.

    Parameters
    ----------
    settings : Settings

    Attributes
    ----------
    wanted : dict of str to set of Piece
        By problem, what is expected to be run.
    fresh : dict of str to int
        Number of schemes of the problems that were not judged yet.
    screened : dict of str to list of float
        Measured seconds of each scheme without paths, by problem.
    sampled : dict of str to (dict of str to (float, float))
        Measured seconds of each scheme on paths, by problem, and how often they are those of the first block.
    spent : float
        All seconds measured.
    """

    settings: Settings
    wanted: dict[str, set[Piece]] = field(default_factory=dict)
    fresh: dict[str, int] = field(default_factory=dict)
    screened: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    sampled: dict[str, dict[str, tuple[float, float]]] = field(default_factory=lambda: defaultdict(dict))
    spent: float = 0.0
    _known: dict[str, float] = field(default_factory=dict)

    def expect(self, problem: str, pieces: Iterable[Piece], *, fresh: bool = False) -> None:
        """Take note of what is expected to be run of a problem from now on, in place of what was before.

        Parameters
        ----------
        problem : str
            Label.
        pieces : iterable of Piece
        fresh : bool
            Whether no paths have told yet how many of them are needed.
        """
        self._known.pop(problem, None)
        self.wanted[problem] = set(pieces)
        self.fresh.pop(problem, None)
        if fresh:
            self.fresh[problem] = len({scheme for scheme, _ in self.wanted[problem]})

    def heard(self, problem: str, block: int, seconds: Iterable[tuple[str, float]]) -> None:
        """Take note of what some schemes took on a block of a problem.

        Parameters
        ----------
        problem : str
            Label.
        block : int
        seconds : iterable of (str, float)
            Measured, of each scheme.
        """
        self._known.pop(problem, None)
        for scheme, each in seconds:
            self.spent += each
            self.wanted[problem].discard((scheme, block))
            if block == SCREENING:
                self.screened[problem].append(each)
            else:
                before, times = self.sampled[problem].get(scheme, (0.0, 0.0))
                self.sampled[problem][scheme] = before + each, times + self._weigh(block)

    def over(self, problem: str, block: int) -> None:
        """Take note that a block of a problem is done, whether it was computed or known before."""
        self._known.pop(problem, None)
        self.wanted[problem] = {piece for piece in self.wanted[problem] if piece[1] != block}

    @property
    def left(self) -> float:
        """Seconds that are left."""
        mean, whole = self._mean, 0.0
        for problem in self.wanted:
            # Of a problem of which nothing was measured, this is in multiples of the mean, and changes with it alone.
            begun = bool(self.screened[problem] or self.sampled[problem])
            if problem not in self._known:
                self._known[problem] = self._sum_left(problem, mean if begun else 1.0)
            whole += self._known[problem] * (1.0 if begun else mean)
        return whole

    def _sum_left(self, problem: str, mean: float) -> float:
        """Return the seconds that are left of a problem; `mean` are those of a scheme without paths if not known."""
        screening = fmean(self.screened[problem] or [mean])
        known = {scheme: seconds / times for scheme, (seconds, times) in self.sampled[problem].items()}
        first = (sum(known.values()) + ALIKE * FIRST * screening) / (len(known) + ALIKE)
        left = 0.0
        for scheme, block in self.wanted[problem]:
            left += screening if block == SCREENING else known.get(scheme, first) * self._weigh(block)
        if problem in self.fresh:
            further = range(self.settings.ends[0], self.settings.blocks)
            whole = sum(known.values()) + (self.fresh[problem] - len(known)) * first
            left += AGAIN * whole * sum(map(self._weigh, further))
        return left

    def _weigh(self, block: int) -> float:
        """Return what a block costs, in multiples of the first one."""
        return 1.0 + GROWTH * (self.settings.paths_of(block) / self.settings.paths_of(0) - 1.0)

    @property
    def _mean(self) -> float:
        """Seconds of a scheme without paths; guessed from those of paths where such were known before."""
        if without := [each for known in self.screened.values() for each in known]:
            return fmean(without)
        first = [seconds / times for known in self.sampled.values() for seconds, times in known.values()]
        return fmean(first) / FIRST if first else 0.0


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
