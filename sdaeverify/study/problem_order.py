"""In which order problems run: those that take longest begin, so that workers end together."""

from collections.abc import Iterable

from ..contracts.settings import Settings
from ..simulate.reference import OWN_REFERENCE
from .plan import ProblemPlan
from .problem_run import ProblemRun


def widest_first(problems: Iterable[ProblemRun]) -> list[ProblemRun]:
    """Return problems in the order in which single steps are looked at."""
    return sorted(problems, key=lambda problem: -_breadth(problem.plan))


def longest_first(problems: Iterable[ProblemRun], settings: Settings) -> list[ProblemRun]:
    """Return problems in the order in which paths are drawn."""
    return sorted(problems, key=lambda problem: -_weight(problem.plan, settings))


def _weight(plan: ProblemPlan, settings: Settings) -> int:
    """Return how much the first paths of a problem weigh beside those of others: steps of all its schemes.

    Steps on so few paths cost their calls, whatever the problem; a scheme that is its own truth makes most of them.
    """
    assert plan.problem is not None
    last = settings.levels - 1
    own = OWN_REFERENCE if plan.problem.pathwise is None else 0
    steps = sum(settings.steps) + (settings.coarsest << (last + own) if own else 0)
    return steps * len({cell.scheme for cell in (*plan.runnable, *plan.control_cells)})


def _breadth(plan: ProblemPlan) -> int:
    """Return how much the screening of a problem weighs: cells, times the noises that nodes are of."""
    assert plan.problem is not None
    return len(plan.runnable) * (1 + plan.problem.noise_dim)
