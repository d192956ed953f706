"""Uniform convergence along paths, in the mean of sup_t |X_h(t) - X(t)|^p: claimed with a rate or without one.

It is asked on the grid, as the maximum over the coarsest grid times against the truth, and separately in continuous
time, of piecewise linear interpolants against the scheme's own finest paths. There components as rough as Brownian
motion read about 1/2, and less on steps that are not small, where it is sqrt(h log(1/h)): whatever the scheme does on
its grid, nothing in it knows the path between two grid points.

Two kinds of claims are known: an order, and ``converges`` without one; see `_convergence` for what can be verified of
that. The verdict is taken from p = 1; the slopes for p = 2 and p = 4 stand beside it.
"""

from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any, ClassVar

from ...arrays import Parts
from ...contracts.error_sizes import ErrorSizes
from ...contracts.finding import Finding, Judgement, Opinion
from ...contracts.measure import Evidence, Measure
from ...contracts.scheme import Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally, packed, unpacked
from ...forms import Problem
from ...probe.local.consistency import Consistency, consistency
from ...probe.local.delay_links import linked, loses_algebraic
from ...probe.local.strong_defects import no_local_order
from ...probe.step.one_step import OneStep
from ...registry.hookspecs import hookimpl
from ..error_sizes import of_paths
from ..judge import coverage, finding, leave_open, no_claim, withhold_in_doubt
from ..path_errors.errors import STATE
from ..path_errors.level_rows import level_rows
from .findings import judge_pair
from .notes import ON_GRID, UniformObserver, pairs_of
from .one_step import judge_consistency

PROBED = "local consistency"
NORMS = {"L2": 2, "L4": 3}


class Uniform(Measure):
    """Convergence of the largest error in time, with or without a rate."""

    name: ClassVar[str] = "uniform"

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Refuse schemes that claim nothing of it here: it is not sampled for them; and bounded increments."""
        if scheme.law.bounded:
            return f"its {scheme.law.name} increments are not Brownian: it has no paths to converge along"
        return no_claim(scheme, problem, self.name, "uniform convergence")

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> UniformObserver:
        """Return the notebook for one block."""
        return UniformObserver(problem, parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the defects of one step, where it can be probed."""
        pair = linked(scheme, view)
        if loses_algebraic(scheme, view) or no_local_order(*pair):
            return Tally()
        return packed(PROBED, consistency(*pair))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return two findings for each component, and their levels."""
        local = _local_opinions(evidence)
        pairs = (judge_pair(evidence, grid, time, local.get(name)) for name, grid, time in pairs_of(evidence))
        judged = list(chain.from_iterable(pairs))
        findings = withhold_in_doubt([each.finding for each in judged]) + list(_unknown_components(evidence))
        rows = (level_rows(each.quantity, each.fitted, NORMS) for each in judged)
        return Judgement(tuple(findings), tuple(chain.from_iterable(rows)))

    def error_sizes(self, evidence: Evidence) -> Mapping[str, ErrorSizes]:
        """Return the largest errors on the grid; those in continuous time are of the paths' own roughness."""
        return {grid.name: of_paths(evidence, grid) for _, grid, _ in pairs_of(evidence)}


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Uniform()]


def _local_opinions(evidence: Evidence) -> dict[str, Opinion]:
    """Return what one step says of each component and of the full state: whether it follows the equation."""
    record = unpacked(PROBED, Consistency, evidence.tally)
    if record is None:
        return {}
    names = enumerate(OneStep(*linked(evidence.scheme, evidence.view)).names)
    return {**{name: judge_consistency(record, i) for i, name in names}, STATE: judge_consistency(record)}


def _unknown_components(evidence: Evidence) -> Iterator[Finding]:
    """Yield findings on the components that the truth does not know."""
    view, known = evidence.view, {name for name, *_ in pairs_of(evidence)}
    start = evidence.scheme.start(view, 1, evidence.step_sizes[0])
    for name in evidence.scheme.parts(view, start):
        if name not in known:
            covered = coverage(evidence, Uniform.name, f"{name}{ON_GRID}")
            yield finding(covered, leave_open(covered, f"the problem's truth does not know {name}"))
