"""Uniform convergence along paths, in the mean of sup_t |X_h(t) - X(t)|^p: claimed with or without a rate.

It is tested on the grid, as the maximum over the coarsest grid times relative to the truth, and separately in
continuous time, for piecewise linear interpolants relative to the scheme's own finest paths. There, components as
rough as Brownian motion have about the order 1/2, and less on steps that are not small, where it is sqrt(h log(1/h)).
This holds for any scheme, because its grid values do not determine the path between two grid points.

Two kinds of claims are supported: an order, and ``converges`` without one; see `findings` for the verification of the
latter. A claim that names no quantities is tested on both, except one of an order above 1/2, which is about grid
points; in continuous time it must name its quantities, such as ``x in continuous time``. The verdict uses p = 1;
the slopes for p = 2 and p = 4 are reported as well.
"""

from collections import deque
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, pairwise
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array, Parts
from ...contracts.finding import Finding, Judgement
from ...contracts.measure import Evidence, Measure, Snapshot
from ...contracts.scheme import Scheme
from ...contracts.settings import Settings
from ...contracts.tally import Tally
from ...forms import Problem
from ...registry.hookspecs import hookimpl
from ...verdicts.coverage import why_not_claimed
from ...verdicts.opinions import finding
from ..path_errors.consistency import consistency_opinions, probe_consistency
from ..path_errors.errors import STATE, ErrorObserver, tally_errors
from ..path_errors.quantity import ERROR_COLUMNS, Quantity, judge_together, quantities_of, unknown_components
from .findings import judge_pair

# Size: means of e^p are recorded for p = 1/2, 1, 2, 4; the last two of them are reported.
POWERS = 4
NORMS = {"L2": 2, "L4": 3}
# Size: halvings between a level and the grid on which its interpolant is compared.
HALVINGS = 2
# Size: intervals of that grid in a step.
POINTS = 2**HALVINGS
CONTINUOUS = "continuous"
ON_GRID, IN_TIME = " on the grid", " in continuous time"


class ContinuousErrors:
    """Accumulates c_l = max_t |X_l(t) - X(t)|, X_l the interpolant of level l, X the scheme at the finest level.

    The maximum is over the quarters of each step. A Brownian path deviates from its interpolant on N steps by sqrt(h)
    times a maximum over N independent bridges. With the same points inside each step that maximum is the same
    fraction of the supremum at all levels, so it does not tilt a slope. The finest grid would, because it resolves
    fewer points of a short step. So levels two halvings coarser than the finest are compared, and coarser ones.

    A level is always a few steps ahead of the finer ones; only the values of these steps are stored.

    Parameters
    ----------
    parts : mapping of str to ndarray, shape (n, P)
        Initial components.
    names : sequence of str
        Components that are compared.
    settings : Settings
    """

    def __init__(self, parts: Parts, names: Sequence[str], settings: Settings) -> None:
        self.names, self.settings = list(names), settings
        self.top = settings.levels - 1
        self.levels = range(max(0, settings.levels - HALVINGS))
        self.wanted: Sequence[Container[int]] = [
            range(1, steps + 1) if level in self.levels or level == self.top else ()
            for level, steps in enumerate(settings.steps)
        ]
        start = self._rows(parts)
        self.ahead = [deque([start]) for _ in self.levels]
        self.inside: list[list[Array]] = [[] for _ in self.levels]
        ends = np.cumsum([0, *(len(parts[name]) for name in self.names)]).tolist()
        self.slices = [slice(*pair) for pair in pairwise(ends)]
        self.squares = np.zeros((len(self.quantities), len(self.levels), start.shape[-1]))

    @property
    def quantities(self) -> list[str]:
        """The components and, if there are several, the full state."""
        return self.names if len(self.names) == 1 else [*self.names, STATE]

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Store a value of a level, or compare with the value of the finest level."""
        x = self._rows(parts)
        if level < self.top:
            self.ahead[level].append(x)
            return
        for coarse in self.levels:
            if step % 2 ** (self.top - HALVINGS - coarse) == 0:
                self.inside[coarse].append(x)
                if len(self.inside[coarse]) == POINTS:
                    self._compare(coarse)

    def tally(self) -> Tally:
        """Return sums of the errors' powers over groups of paths, and the largest errors."""
        return tally_errors(CONTINUOUS, dict(zip(self.quantities, np.sqrt(self.squares), strict=True)))

    def _compare(self, level: int) -> None:
        """Compare at the quarters of the step that ends here."""
        left = self.ahead[level].popleft()
        chord, rise = left.copy(), (self.ahead[level][0] - left) / POINTS
        gap = np.empty_like(chord)
        for x in self.inside[level]:
            chord += rise
            np.subtract(chord, x, out=gap)
            for noted, square in zip(self.squares, self._squares(gap), strict=True):
                np.maximum(noted[level], square, out=noted[level])
        self.inside[level] = []

    def _rows(self, parts: Parts) -> Array:
        return np.concatenate([parts[name] for name in self.names])

    def _squares(self, gap: Array) -> list[Array]:
        # einsum, because a sum over few rows takes several times as long.
        squares = [np.einsum("np,np->p", gap[rows], gap[rows]) for rows in self.slices]
        return squares if len(squares) == 1 else [*squares, sum(squares[1:], squares[0])]


class UniformObserver:
    """Accumulates errors on the coarsest grid relative to the truth, and between grid points to the finest level."""

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.grid = ErrorObserver(parts, settings, POWERS)
        self.between = ContinuousErrors(parts, _components_of_truth(problem, parts), settings)

    @property
    def wanted(self) -> Sequence[Container[int]]:
        """Steps of each level that are used between grid points."""
        return self.between.wanted

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Accumulate the components between grid points."""
        self.between.after_step(level, step, parts)

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Accumulate the errors on the grid."""
        self.grid.after_coarsest_step(snapshot)

    def tally(self) -> Tally:
        """Return the evidence on the grid and in continuous time."""
        return self.grid.tally(at_end=False).merge(self.between.tally())


def pairs_of(evidence: Evidence) -> Iterator[tuple[str, Quantity, Quantity]]:
    """Yield each component with its quantity on the grid and in continuous time."""
    for grid, between in zip(quantities_of(evidence), quantities_of(evidence, CONTINUOUS), strict=True):
        yield grid.name, replace(grid, name=f"{grid.name}{ON_GRID}"), replace(between, name=f"{grid.name}{IN_TIME}")


def _components_of_truth(problem: Problem, parts: Parts) -> list[str]:
    """Return the components that the truth has; all of them if the scheme is its own reference."""
    truth = problem.pathwise
    return [name for name in parts if truth is None or name in truth.parts(0.0, truth.start(1))]


class Uniform(Measure):
    """Convergence of the largest error in time, with or without a rate."""

    name: ClassVar[str] = "uniform"
    follows: ClassVar[str] = "paths"
    detail_columns: ClassVar[Mapping[str, str]] = {
        "std_error": "standard error of the order along paths",
        "order_L2": "the same in the L2 norm",
        "order_L4": "the same in the L4 norm",
        "fitted_levels": "levels that the order is fitted to",
        "bias_bound": "bound on the bias of the order due to the error of the reference",
        "contrast": "order of the errors minus that of their differences; far below 0 if the limit is wrong",
        "contrast_low": "lower end of its interval",
        "contrast_high": "upper end of its interval",
    }
    level_columns: ClassVar[Mapping[str, str]] = {**ERROR_COLUMNS, "estimate_L4": "the error in the L4 norm"}

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: bounded increments, or no claim, so that no paths are sampled."""
        if scheme.law.bounded:
            return f"its {scheme.law.name} increments are not Brownian, so that it does not converge along paths"
        return why_not_claimed(scheme, problem, self.name, "uniform convergence")

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> UniformObserver:
        """Return the observer of one block."""
        return UniformObserver(problem, parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the defects of one step, if it can be probed."""
        return probe_consistency(scheme, view)

    def judge(self, evidence: Evidence) -> Judgement:
        """Return two findings for each component, and their levels."""
        local = consistency_opinions(evidence)
        pairs = (judge_pair(evidence, grid, time, local.get(name)) for name, grid, time in pairs_of(evidence))
        return judge_together(list(chain.from_iterable(pairs)), _unknown_findings(evidence), NORMS)


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Uniform()]


def _unknown_findings(evidence: Evidence) -> Iterator[Finding]:
    """Return findings on the components that the truth lacks."""
    return (finding(covered, opinion) for _, covered, opinion in unknown_components(evidence, Uniform.name, ON_GRID))
