"""How much work a study has left, from the measured seconds of what is done."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from statistics import fmean

# Until a further look was measured, a path of it is taken for so much of one of the first, which includes probing.
FURTHER = 0.25


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

    The first look at a problem costs what its schemes have cost so far, or those of other problems on average; a
    further one what its paths have cost; and as many problems are looked at again as were so far.

    Parameters
    ----------
    schemes : mapping of str to int
        Number of schemes of each problem that is open, by its label.
    first : int
        Paths of the first look.

    Attributes
    ----------
    done, further : dict of str to list of float
        Measured seconds of each scheme at the first look, and of a scheme and path at further ones, by problem.
    over : set of str
        Problems whose first look is over.
    first_looks, further_looks : Looks
    spent : float
        All seconds measured.
    """

    schemes: Mapping[str, int]
    first: int
    done: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    further: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    over: set[str] = field(default_factory=set)
    first_looks: Looks = field(default_factory=Looks)
    further_looks: Looks = field(default_factory=Looks)
    spent: float = 0.0

    def heard(self, problem: str, seconds: float, schemes: int, paths: int | None) -> None:
        """Take note of what some schemes took on a problem; `paths` is None for the first look."""
        self.spent += seconds
        if paths is None:
            self.done[problem] += [seconds / schemes] * schemes
        else:
            self.further[problem].append(seconds / (schemes * paths))

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
        waiting = {name: count for name, count in self.schemes.items() if name not in self.over}
        first = sum(max(0, count - len(self.done[name])) * self._first(name) for name, count in waiting.items())
        further = sum(schemes * paths * self._path(name) for name, schemes, paths in queued)
        expected = sum(count * self.first * self._path(name) for name, count in waiting.items())
        # A look has as many paths as all before it: what follows one costs twice as much.
        return first + further * (1.0 + 2.0 * self.further_looks.share) + self.first_looks.share * expected

    def _first(self, problem: str) -> float:
        known = self.done[problem] or [seconds for all_ in self.done.values() for seconds in all_]
        return fmean(known) if known else 0.0

    def _path(self, problem: str) -> float:
        if self.further[problem]:
            return fmean(self.further[problem])
        return FURTHER * self._first(problem) / self.first
