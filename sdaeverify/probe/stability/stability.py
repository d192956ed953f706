"""Mean-square stability of a scheme on a linear problem: spectral radius of its second-moment operator.

E |x_n|^2 tends to 0 (with additive noise: stays bounded) if and only if rho < 1; algebraic components add only zero
eigenvalues. Sampling E |x_n|^2 instead gives wrong verdicts if paths too rare to be drawn dominate it.
Memory without influence on the comparable components is removed from the operator, and so are states that violate the
problem's constraints.

The cost is bounded in terms of the memory's dimension k: for each step size, nodes whose matrices have at most
`ENTRIES` entries together, k rounds to find the observed part, and eigenvalues of a matrix of k (k + 1)/2 <= 300 rows
or `RESTARTS` restarts of Arnoldi's method. The scan grows to at most four times its initial number of step sizes.

With a delay the state includes the history, and the set of stable step sizes need not be an interval: if the delay is
no multiple of the step size, stability at one step size does not imply it at a smaller one. The scan includes several
positions of the delay between mesh points.
"""

from collections.abc import Callable, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Delayed, Problem
from ..linear.delay_equation import UNIT, at_rest, is_autonomous, is_scalar, linear_delay
from ..linear.delay_step import limits, probe_step, why_not_lasting_step
from ..linear.equation import linear_equation, why_not_linear_equation
from ..linear.linear_map import MemoryStep
from ..linear.observable_part import essential_equation, essential_operator
from ..linear.second_moments import Operator
from ..linear.step_moments import step_moments, why_not_linear_step
from ..step.one_step import OneStep
from .delay_radius import radius
from .spectral import SpectralRadius, spectral_radius
from .windows import Window, crossings, doubtful, signs, stable_windows

# Smallest range of the scan, in the problem's unit of time and in its own time scale, with its number of step sizes.
# Size: of the scan.
LEAST, MOST, COUNT = 1e-3, 1e3, 60
# Largest factor by which refinement increases the number of step sizes.
# Size: of the scan.
REFINED = 4

Row = tuple[float, ...]
# Step sizes of the scan with a delay: from this part of the delay, or of the equation's own time scale if that is
# shorter; one per factor 2 if the history is longer than the third, and none if it is longer than the fourth.
# Size: of the scan.
FINE, OWN, LONG, LONGEST = 1.0 / 64.0, 0.1, 512, 1 << 17
# Size: of the scan.
PER_DECADE, LONGER = 12, 16
# Size: of the scan.
SMALLEST_M, POSITIONS = range(1, 25), (0.0, 0.23, 0.49, 0.77)
UNKNOWN = SpectralRadius(np.nan, np.inf)
# Decided and undecided answers as numbers.
NUMBERS = {True: 1.0, False: 0.0, None: np.nan}


class Radius(NamedTuple):
    """Spectral radius at S step sizes; each field has shape (S,).

    Attributes
    ----------
    h, rho : ndarray
    error : ndarray
        Bound of the error by quadrature and linear algebra; infinite near a pole.
    defect : ndarray
        Relative deviation from linearity in the state.
    failed : ndarray
        1 if the scheme found no root, else 0.
    pole : ndarray
        Standard deviations from which the second moment is infinite; infinite if the moment is finite.
    """

    h: Array
    rho: Array
    error: Array
    defect: Array
    failed: Array
    pole: Array

    @property
    def sign(self) -> Array:
        """-1 where the scheme is stable, +1 where it is unstable, 0 where neither is certain."""
        return np.where(self.failed > 0.0, 0, signs(self.rho, self.error))


class StabilityRecord(NamedTuple):
    """Stability of a scheme on a linear problem.

    Attributes
    ----------
    scanned : ndarray, shape (6, S)
        `Radius` on the grid, ascending in h; empty if the grid was not scanned.
    asked : ndarray, shape (6, L)
        `Radius` at the run's step sizes.
    boundaries : ndarray, shape (C,)
        Step sizes in the range of the grid at which rho crosses 1.
    abscissa : float
        Growth rate of the second moments of the problem's linear part.
    decays : float
        1 if the growth rate is certainly negative, 0 if it is not, NaN if rounding errors are too large to decide.
    at_rest : float
        1 if zero is a solution of the problem, else 0.
    """

    scanned: Array
    asked: Array
    boundaries: Array
    abscissa: float
    decays: float
    at_rest: float

    @property
    def scan(self) -> Radius:
        """Spectral radius on the grid, one field per row of `scanned`."""
        return Radius(*self.scanned)

    @property
    def run(self) -> Radius:
        """Spectral radius at the run's step sizes."""
        return Radius(*self.asked)

    @property
    def most(self) -> float:
        """Largest of the run's step sizes such that the scheme is stable at it and at all smaller ones; 0 if none."""
        order = np.argsort(self.run.h)
        stable = np.cumprod(self.run.sign[order] < 0).astype(bool)
        return float(self.run.h[order].max(where=stable, initial=0.0))

    @property
    def windows(self) -> list[Window]:
        """Intervals of step sizes on which the scheme is stable."""
        return stable_windows(self.scan.h, self.scan.sign, self.boundaries)


def why_not_stability(scheme: Scheme, view: Problem) -> str:
    """Return why mean-square stability cannot be determined, or an empty string."""
    one_step = OneStep(scheme, view)
    reason = why_not_linear_equation(view) or one_step.why_not_at_nodes() or one_step.why_not_comparable()
    if reason := reason or why_not_linear_step(scheme, view) or one_step.untold(scheme.start(view, 1, view.horizon)):
        return reason
    # On constrained problems the operator is restricted to states that `enter` creates from admissible ones.
    return one_step.why_not_entered(run=False) if view.has_constraints else ""


def why_not_in_runs(scheme: Scheme, view: Problem) -> str:
    """Return that steps of a run do not continue from admissible states as single steps do, or an empty string.

    It makes a run, so it is called only when evidence is computed.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_stability` is empty for the pair.
    """
    return OneStep(scheme, view).why_not_entered() if view.has_constraints else ""


def stability(scheme: Scheme, view: Problem, step_sizes: Sequence[float], *, scan: bool = True) -> StabilityRecord:
    """Return the spectral radius on a wide grid and at some step sizes, and the step sizes at which it crosses 1.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_stability` is empty for the pair.
    step_sizes : sequence of float
    scan : bool
        Whether to scan the grid; if not, `scanned` and `boundaries` are empty.

    Returns
    -------
    StabilityRecord
    """
    one_step = OneStep(scheme, view)
    equation = essential_equation(one_step)
    time = 1.0 / equation.rate if equation.rate > 0.0 else 1.0
    low, high = LEAST * min(1.0, time), MOST * max(1.0, time)
    h = np.geomspace(low, high, round(COUNT * np.log(high / low) / np.log(MOST / LEAST)) if scan else 0)
    with np.errstate(all="ignore"):
        # The scan needs signs and six digits only, so that fewer points than all atoms suffice.
        found = refine_scan(lambda size: _radius(one_step, size, atoms=False), h)
        run = radii([_radius(one_step, size) for size in step_sizes])
        boundaries = crossings(lambda size: step_radius(one_step, size), found.h, found.sign)
    at_rest = float(linear_equation(one_step.equation).starts_at_rest)
    growth = equation.abscissa, NUMBERS[equation.decays()], at_rest
    return StabilityRecord(np.array(found), np.array(run), boundaries, *growth)


def refine_scan(found: Callable[[float], Row], sizes: Array) -> Radius:
    """Return the radius on a grid, refined between neighbours where it may cross 1 and return.

    Parameters
    ----------
    found : callable, h -> fields of `Radius` at one step size
    sizes : ndarray, shape (S,)
        Ascending.

    Returns
    -------
    Radius
    """
    rows = [found(float(h)) for h in sizes]
    while len(rows) < REFINED * len(sizes):
        scan = radii(rows)
        more = doubtful(scan.h, scan.rho, scan.sign)
        if not len(more):
            break
        rows = sorted([*rows, *(found(float(h)) for h in more)])
    return radii(rows)


def radii(rows: Sequence[Row]) -> Radius:
    """Return rows of values at some step sizes as arrays of each field."""
    return Radius(*np.array(rows).reshape(-1, len(Radius._fields)).T)


def step_radius(one_step: OneStep, h: float) -> float:
    """Return the spectral radius of a step of size h, without checks or certificate."""
    operator = step_moments(one_step, h, far=False, atoms=False).operator
    return spectral_radius(_essential(one_step, h, operator), certified=False).rho


def _radius(one_step: OneStep, h: float, *, atoms: bool = True) -> Row:
    found = step_moments(one_step, h, atoms=atoms)
    finer, coarser = found.operator, found.coarser
    # Without a second rule the error of quadrature is unknown.
    rho, error = UNKNOWN if coarser is None else spectral_radius(_essential(one_step, h, finer))
    if coarser is not None and coarser is not finer:
        error += abs(rho - spectral_radius(_essential(one_step, h, coarser), certified=False).rho)
    return h, rho, error + found.left_out, found.defect, float(found.failed), found.pole


def _essential(one_step: OneStep, h: float, operator: Operator) -> Operator:
    return essential_operator(MemoryStep(one_step, h), operator)


def why_not_delay_stability(scheme: Scheme, view: Delayed) -> str:
    """Return why mean-square stability cannot be determined, or an empty string."""
    if scheme.law.clip:
        return "the variance of its clipped increments is not available"
    if not is_autonomous(view):
        return "its coefficients depend on time"
    if not limits(scheme, view, view.delay / 4.0):
        return "a step is linear neither at small states nor at large ones"
    return why_not_lasting_step(scheme, view, view.delay / 4.0)


def delay_stability(
    scheme: Scheme, view: Delayed, step_sizes: Sequence[float], scale: float, *, scan: bool = True
) -> StabilityRecord:
    """Return the spectral radius on a wide grid and at some step sizes, and the step sizes at which it crosses 1.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Problem in the scheme's form; `why_not_delay_stability` is empty for the pair.
    step_sizes : sequence of float
    scale : float
        Size of the states at which the step is taken as linear, see `limits`.
    scan : bool
        As for `stability`.

    Returns
    -------
    StabilityRecord
        For an equation in several dimensions, growth rate and stability are unknown: NaN.
    """

    def row(h: float) -> Row:
        probed, mesh = probe_step(scheme, view, h, scale), view.mesh(h)
        rho, width = radius(probed.step, mesh) if mesh.m <= LONGEST else UNKNOWN
        return h, rho, width, probed.defect, float(probed.failed), np.inf

    with np.errstate(all="ignore"):
        abscissa, decays = _equation(view, scale)
        grid = _scan(view, scale) if scan else np.array([])
        found, run = refine_scan(row, grid), radii([row(h) for h in step_sizes])
        boundaries = crossings(lambda h: row(h)[1], found.h, found.sign)
    return StabilityRecord(np.array(found), np.array(run), boundaries, abscissa, decays, float(at_rest(view)))


def _equation(view: Delayed, scale: float) -> tuple[float, float]:
    if not is_scalar(view):
        return np.nan, np.nan
    equation = linear_delay(view, scale)
    return equation.growth_rate, NUMBERS[equation.stable]


def _scan(view: Delayed, scale: float) -> Array:
    rate = 0.0
    if is_scalar(view):
        A, B, c, d, _ = linear_delay(view, scale)
        rate = abs(A) + abs(B) + (abs(c) + abs(d)) ** 2
    delay = view.delay
    least = min(FINE * delay, OWN / rate if rate else np.inf)
    low = max(least, delay / LONG)
    count = round(PER_DECADE * np.log10(delay / low))
    shorter = np.geomspace(least, low, ceil(np.log2(low / least)) + 1)[:-1]
    between = np.array([delay / (m - part) for m in SMALLEST_M for part in POSITIONS if m - part >= 1.0])
    # Beyond the delay, bounded terms of the unknown take part in the solve: at large states the step is not linear.
    longer = np.geomspace(delay, MOST * delay, LONGER)[1:]
    parts = [shorter, np.geomspace(low, delay, count)[:-1], between, longer]
    return np.unique(np.concatenate(parts[: 3 if scale > UNIT else 4]))
