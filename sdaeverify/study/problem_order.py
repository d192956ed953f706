"""Order in which problems run: the longest first, so that workers finish at about the same time."""

from collections.abc import Iterable

from ..contracts.settings import Settings
from ..simulate.reference import OWN_REFERENCE
from .plan import ProblemPlan
from .problem_run import ProblemRun


def widest_first(problems: Iterable[ProblemRun]) -> list[ProblemRun]:
    """Return problems in the order of their screening, which evaluates single steps."""
    return sorted(problems, key=lambda problem: -_breadth(problem.plan))


def longest_first(problems: Iterable[ProblemRun], settings: Settings) -> list[ProblemRun]:
    """Return problems in the order in which their paths are sampled."""
    return sorted(problems, key=lambda problem: -_weight(problem.plan, settings))


def _weight(plan: ProblemPlan, settings: Settings) -> int:
    """Return the estimated cost of a problem's first paths: the number of steps of all its schemes.

    The cost of a step on so few paths is that of its call, for any problem. If the scheme with shorter steps is the
    reference, that reference makes most of the steps.
    """
    assert plan.problem is not None
    last = settings.levels - 1
    own = OWN_REFERENCE if plan.problem.pathwise is None else 0
    steps = sum(settings.steps) + (settings.coarsest << (last + own) if own else 0)
    return steps * len({cell.scheme for cell in (*plan.runnable, *plan.control_cells)})


def _breadth(plan: ProblemPlan) -> int:
    """Return the estimated cost of a problem's screening: cells times 1 + noise dimension, for cubature nodes."""
    assert plan.problem is not None
    return len(plan.runnable) * (1 + plan.problem.noise_dim)
