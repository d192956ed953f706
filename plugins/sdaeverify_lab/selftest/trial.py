"""The plan of a self-test: planted bugs on their problems, registered schemes on the problems of their claims."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase

from sdaeverify import Scheme, SdaeverifyError, UsageError
from sdaeverify.errors import one_line
from sdaeverify.measuring import Verdict
from sdaeverify.studying import (
    Cell,
    Plan,
    ProblemPlan,
    ProblemSpec,
    Registry,
    plan,
    select_measures,
    select_problems,
    select_schemes,
)

from ..cases import Planted

PLANTED = "sdaeverify_planted"
Wanted = Callable[[Scheme, ProblemSpec], bool]


@dataclass(frozen=True)
class SelfTest:
    """A planned self-test.

    Attributes
    ----------
    plan : Plan
        Plan without controls, which could only withdraw verifications and would not affect the result.
    placed : mapping of Planted to ProblemSpec
        Planted bugs that can be run, with their problems.
    missing : mapping of Planted to str
        Reasons why the other planted bugs cannot be run.
    """

    plan: Plan
    placed: Mapping[Planted, ProblemSpec] = field(default_factory=dict)
    missing: Mapping[Planted, str] = field(default_factory=dict)

    def plan_of(self, wanted: Callable[[Scheme], bool]) -> Plan:
        """Return the part of the plan with the cells of some schemes."""
        parts = (
            replace(each, cells=tuple(cell for cell in each.cells if wanted(cell.scheme)))
            for each in self.plan.problems
        )
        return Plan(tuple(part for part in parts if part.cells))


def selftest_trial(registry: Registry, only: str = "*") -> SelfTest:
    """Plan a self-test.

    Parameters
    ----------
    registry : Registry
    only : str
        Glob for the name of the scheme or of the problem.

    Returns
    -------
    SelfTest

    Raises
    ------
    UsageError
        If no scheme or problem matches.
    """

    def wanted(scheme: Scheme, spec: ProblemSpec) -> bool:
        return fnmatchcase(scheme.name, only) or fnmatchcase(spec.name, only)

    placed, missing = _place(registry)
    placed = {bug: spec for bug, spec in placed.items() if wanted(bug.scheme, spec)}
    plans = [made for made in _plans(registry, placed, wanted) if made.cells]
    missing = {bug: why for bug, why in missing.items() if fnmatchcase(bug.scheme.name, only)}
    if not (plans or missing):
        raise UsageError(
            f"no planted bug and no claim of a scheme matches {only!r}; '*euler*' matches parts of names"
        )
    # Largest first, so that small problems fill the remaining time of the workers.
    return SelfTest(Plan(tuple(sorted(plans, key=lambda made: -len(made.cells)))), placed, missing)


def _place(registry: Registry) -> tuple[dict[Planted, ProblemSpec], dict[Planted, str]]:
    placed: dict[Planted, ProblemSpec] = {}
    missing: dict[Planted, str] = {}
    for bug in registry.things(PLANTED).values():
        try:
            (placed[bug],) = select_problems(registry, bug.problem)
        except SdaeverifyError as error:
            missing[bug] = one_line(error)
    return placed, missing


def _plans(registry: Registry, placed: Mapping[Planted, ProblemSpec], wanted: Wanted) -> Iterator[ProblemPlan]:
    registered = {spec.label: spec for spec in select_problems(registry)}
    schemes, measures = select_schemes(registry), select_measures(registry)
    for label, spec in {**registered, **{spec.label: spec for spec in placed.values()}}.items():
        wrong = [bug.scheme for bug, place in placed.items() if place.label == label]
        right = [scheme for scheme in schemes if label in registered and wanted(scheme, spec)]
        if wrong or right:
            (made,) = plan([*wrong, *right], [spec], measures, followed=registry.followed).problems
            yield replace(made, cells=tuple(_claiming(made.cells, wrong)), controls=())


def _claiming(cells: tuple[Cell, ...], wrong: list[Scheme]) -> Iterator[Cell]:
    """Yield the cells of claimed measures; for correct schemes only applicable ones."""
    for cell in cells:
        promised = any(claim.measure == cell.measure.name for claim in cell.scheme.promises)
        if promised and (cell.scheme in wrong or cell.verdict is not Verdict.NOT_APPLICABLE):
            yield cell
