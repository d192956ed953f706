"""How much work a study has left, from the measured seconds of what is done."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from statistics import fmean
from typing import NamedTuple

from ..contracts.settings import SCREENING, Settings
from ..simulate.reference import OWN_REFERENCE
from .plan import ProblemPlan

# Guesses, the rounded means of default runs. Seconds of the first paths for each second without paths, and for how
# many schemes this counts beside those of a problem that were measured on paths.
FIRST, ALIKE = 0.6, 2.0
# What each time as many paths as in the first block add to the time of a block, as part of that of the first: the
# rest are its calls.
GROWTH = 0.08
# Part of the further looks at a problem that is taken, as long as its paths have not told anything yet.
AGAIN = 0.15


class LaneKey(NamedTuple):
    """A piece of work: a scheme on a block.

    Attributes
    ----------
    scheme : str
        Label.
    block : int
        Of paths or, in place of them, `SCREENING`.
    stage : int
        How many levels paths take beyond those of the settings.
    """

    scheme: str
    block: int
    stage: int = 0


@dataclass
class Forecast:
    """Seconds of work that are left, those of all workers together.

    A scheme costs without paths what others have cost on its problem, and on a problem not begun what problems have
    cost for their breadth; on its first paths what others have cost there, too, and, as long as these are few, a part
    of what they took without paths; on further paths what its own have cost. Which further ones it takes is said by
    its findings, of how many paths would decide; until there are some, it is a guess.

    Parameters
    ----------
    settings : Settings

    Attributes
    ----------
    wanted : dict of str to set of LaneKey
        By problem, what is expected to be run.
    fresh : dict of str to int
        Number of schemes of the problems that were not judged yet.
    breadths : dict of str to float
        What the screening of a problem weighs, for each of its schemes.
    screened : dict of str to list of float
        Measured seconds of each scheme without paths, by problem.
    sampled : dict of str to (dict of str to (float, float))
        Measured seconds of each scheme on paths, by problem, and how often they are those of the first block.
    spent : float
        All seconds measured.
    """

    settings: Settings
    wanted: dict[str, set[LaneKey]] = field(default_factory=dict)
    fresh: dict[str, int] = field(default_factory=dict)
    breadths: dict[str, float] = field(default_factory=dict)
    screened: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    sampled: dict[str, dict[str, tuple[float, float]]] = field(default_factory=lambda: defaultdict(dict))
    spent: float = 0.0
    _known: dict[str, float] = field(default_factory=dict)

    def expect(self, problem: str, pieces: Iterable[LaneKey], breadth: float | None = None) -> None:
        """Take note of what is expected to be run of a problem from now on, in place of what was before.

        Parameters
        ----------
        problem : str
            Label.
        pieces : iterable of LaneKey
        breadth : float, optional
            What its screening weighs beside those of others; given before paths tell how many of them are needed.
        """
        self._known.pop(problem, None)
        self.wanted[problem] = set(pieces)
        self.fresh.pop(problem, None)
        if breadth is not None:
            self.fresh[problem] = len({piece.scheme for piece in self.wanted[problem]})
            self.breadths[problem] = breadth / max(self.fresh[problem], 1)

    def heard(self, problem: str, measured: Iterable[tuple[LaneKey, float]]) -> None:
        """Take note of what some pieces of a problem took.

        Parameters
        ----------
        problem : str
            Label.
        measured : iterable of (LaneKey, float)
            With the seconds of each.
        """
        self._known.pop(problem, None)
        for piece, seconds in measured:
            self.spent += seconds
            self.wanted[problem].discard(piece)
            if piece.block == SCREENING:
                self.screened[problem].append(seconds)
            else:
                before, times = self.sampled[problem].get(piece.scheme, (0.0, 0.0))
                self.sampled[problem][piece.scheme] = before + seconds, times + self._weigh(piece)

    def over(self, problem: str, block: int, stage: int = 0) -> None:
        """Take note that a block of a problem is done, whether it was computed or known before.

        Parameters
        ----------
        problem : str
            Label.
        block : int
        stage : int, optional
            How many levels it had beyond those of the settings.
        """
        self._known.pop(problem, None)
        self.wanted[problem] = {piece for piece in self.wanted[problem] if piece[1:] != (block, stage)}

    @property
    def left(self) -> float:
        """Seconds that are left."""
        pace, whole = self._pace, 0.0
        for problem in self.wanted:
            # Of a problem of which nothing was measured, this is in multiples of the pace, and changes with it alone.
            begun = bool(self.screened[problem] or self.sampled[problem])
            if problem not in self._known:
                self._known[problem] = self._sum_left(problem, pace if begun else 1.0)
            whole += self._known[problem] * (1.0 if begun else pace)
        return whole

    def _sum_left(self, problem: str, pace: float) -> float:
        """Return the seconds that are left of a problem; `pace` are those of its breadth if they are not known."""
        screening = fmean(self.screened[problem] or [pace * self.breadths[problem]])
        known = {scheme: seconds / times for scheme, (seconds, times) in self.sampled[problem].items()}
        first = (sum(known.values()) + ALIKE * FIRST * screening) / (len(known) + ALIKE)
        left = 0.0
        for piece in self.wanted[problem]:
            paid = known.get(piece.scheme, first)
            left += screening if piece.block == SCREENING else paid * self._weigh(piece)
        if problem in self.fresh:
            begin = self.settings.ends[0] if self.settings.guards is self.settings else 0
            further = (LaneKey("", block) for block in range(begin, self.settings.blocks))
            whole = sum(known.values()) + (self.fresh[problem] - len(known)) * first
            left += AGAIN * whole * sum(map(self._weigh, further))
        return left

    def _weigh(self, piece: LaneKey) -> float:
        """Return what a scheme costs on a block, in multiples of the first one on all levels."""
        share = sum(self.settings.at(piece.stage).steps) / sum(self.settings.steps)
        paths = self.settings.paths_of(piece.block) / self.settings.paths_of(0)
        return share * (1.0 + GROWTH * (paths - 1.0))

    @property
    def _pace(self) -> float:
        """Seconds of the unit of breadth; guessed from those of paths where all screenings were known before."""
        if any(self.screened.values()):
            return self._mean_pace(self.screened)
        first = {p: [seconds / times for seconds, times in known.values()] for p, known in self.sampled.items()}
        return self._mean_pace(first) / FIRST

    def _mean_pace(self, measured: Mapping[str, list[float]]) -> float:
        breadth = sum(self.breadths[problem] * len(each) for problem, each in measured.items())
        return sum(map(sum, measured.values())) / breadth if breadth else 0.0


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
