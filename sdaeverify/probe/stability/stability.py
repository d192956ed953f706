"""Mean-square stability of a scheme on a linear problem: the spectral radius of its second-moment operator.

E |x_n|^2 tends to 0 (with additive noise: stays bounded) exactly if rho < 1; algebraic components only add zero
eigenvalues. Sampling E |x_n|^2 instead gives wrong verdicts where it is carried by paths too rare to be drawn.
Memory that does not act on the comparable components is left out of the operator, and so are states that violate a
problem's constraints.

What it costs is bounded by the memory's dimension k: a step size takes at most so many nodes that their matrices have
`ENTRIES` entries in all, k rounds to find what is observed, and eigenvalues of a matrix of k (k + 1)/2 <= 300 rows or
`RESTARTS` restarts of Arnoldi's method; the scan has at most four times the step sizes that it begins with.

With a delay the history is in the state, and the set of stable step sizes need not be an interval: on meshes that the
delay is no multiple of, stability at one step size does not imply it at a smaller one. The scan takes several
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

# The scan is at least this wide, in the problem's unit of time and in its own time scale, with so many step sizes.
# Size: of the scan.
LEAST, MOST, COUNT = 1e-3, 1e3, 60
# So many times its step sizes a scan may have after it was refined.
# Size: of the scan.
REFINED = 4

Row = tuple[float, ...]
# Step sizes of the scan: down to this part of the delay, or of the equation's own time where that is shorter; one for
# each factor 2 where histories are longer than the one, and none where they are longer than the other.
# Size: of the scan.
FINE, OWN, LONG, LONGEST = 1.0 / 64.0, 0.1, 512, 1 << 17
# Size: of the scan.
PER_DECADE, LONGER = 12, 16
# Size: of the scan.
SMALLEST_M, POSITIONS = range(1, 25), (0.0, 0.23, 0.49, 0.77)
UNKNOWN = SpectralRadius(np.nan, np.inf)
# What is certain, as a number.
NUMBERS = {True: 1.0, False: 0.0, None: np.nan}


class Radius(NamedTuple):
    """The spectral radius at some step sizes, each field of shape (S,).

    Attributes
    ----------
    h, rho : ndarray
    error : ndarray
        What quadrature and linear algebra leave open; infinite beside a pole.
    defect : ndarray
        Of linearity in the state, relative.
    failed : ndarray
        1 where the scheme found no root.
    pole : ndarray
        Standard deviations from which on the second moment is infinite; infinite where it is finite.
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
    """What was found on a scheme and a linear problem.

    Attributes
    ----------
    scanned : ndarray, shape (6, S)
        `Radius` on the grid, ascending in h; empty where it was not looked at.
    asked : ndarray, shape (6, L)
        `Radius` at the run's step sizes.
    boundaries : ndarray, shape (C,)
        Where rho crosses 1 on the grid's range.
    abscissa : float
        Growth rate of the problem's second moments, its linear part alone.
    decays : float
        1 if that is negative for certain, 0 if it is not, NaN if the arithmetic does not tell.
    at_rest : float
        1 if zero is a solution of the problem.
    """

    scanned: Array
    asked: Array
    boundaries: Array
    abscissa: float
    decays: float
    at_rest: float

    @property
    def scan(self) -> Radius:
        """The spectral radius on the grid."""
        return Radius(*self.scanned)

    @property
    def run(self) -> Radius:
        """The spectral radius at the run's step sizes."""
        return Radius(*self.asked)

    @property
    def most(self) -> float:
        """The largest of the run's step sizes up to which the scheme is stable at all of them, 0 if there is none."""
        order = np.argsort(self.run.h)
        stable = np.cumprod(self.run.sign[order] < 0).astype(bool)
        return float(self.run.h[order].max(where=stable, initial=0.0))

    @property
    def windows(self) -> list[Window]:
        """The intervals of step sizes on which the scheme is stable."""
        return stable_windows(self.scan.h, self.scan.sign, self.boundaries)


def why_not_stability(scheme: Scheme, view: Problem) -> str:
    """Return why mean-square stability cannot be asked for, or an empty string."""
    one_step = OneStep(scheme, view)
    reason = why_not_linear_equation(view) or one_step.why_not_at_nodes() or one_step.why_not_comparable()
    if reason := reason or why_not_linear_step(scheme, view) or one_step.untold(scheme.start(view, 1, view.horizon)):
        return reason
    # Of admissible states alone one has to know how the scheme goes on from them; others are those of its memory.
    return one_step.why_not_entered(run=False) if view.has_constraints else ""


def why_not_in_runs(scheme: Scheme, view: Problem) -> str:
    """Return that steps of a run do not go on from admissible states as single steps do, or an empty string.

    It makes a run, and is asked where evidence is made.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of a pair that `why_not_stability` has nothing against.
    """
    return OneStep(scheme, view).why_not_entered() if view.has_constraints else ""


def stability(scheme: Scheme, view: Problem, step_sizes: Sequence[float], *, scan: bool = True) -> StabilityRecord:
    """Return the spectral radius on a wide grid and at some step sizes, and where it crosses 1.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of a pair that `why_not_stability` has nothing against.
    step_sizes : sequence of float
    scan : bool
        Whether the grid is looked at; if not, `scanned` and `boundaries` are empty.

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
        # Of the scan, signs count and six digits are told.
        found = refine_scan(lambda size: _radius(one_step, size, atoms=False), h)
        run = radii([_radius(one_step, size) for size in step_sizes])
        boundaries = crossings(lambda size: step_radius(one_step, size), found.h, found.sign)
    at_rest = float(linear_equation(one_step.equation).starts_at_rest)
    growth = equation.abscissa, NUMBERS[equation.decays()], at_rest
    return StabilityRecord(np.array(found), np.array(run), boundaries, *growth)


def refine_scan(found: Callable[[float], Row], sizes: Array) -> Radius:
    """Return the radius on a grid, and amid neighbours between which it may cross 1 and come back.

    Parameters
    ----------
    found : callable, h -> the fields of `Radius` at one step size
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
    """Return what was found at some step sizes, field by field."""
    return Radius(*np.array(rows).reshape(-1, len(Radius._fields)).T)


def step_radius(one_step: OneStep, h: float) -> float:
    """Return the spectral radius of a step of size h, nothing being checked."""
    operator = step_moments(one_step, h, far=False, atoms=False).operator
    return spectral_radius(_essential(one_step, h, operator), certified=False).rho


def _radius(one_step: OneStep, h: float, *, atoms: bool = True) -> Row:
    found = step_moments(one_step, h, atoms=atoms)
    finer, coarser = found.operator, found.coarser
    # Without a second rule nothing is certain, whatever the arithmetic is.
    rho, error = UNKNOWN if coarser is None else spectral_radius(_essential(one_step, h, finer))
    if coarser is not None and coarser is not finer:
        error += abs(rho - spectral_radius(_essential(one_step, h, coarser), certified=False).rho)
    return h, rho, error + found.left_out, found.defect, float(found.failed), found.pole


def _essential(one_step: OneStep, h: float, operator: Operator) -> Operator:
    return essential_operator(MemoryStep(one_step, h), operator)


def why_not_delay_stability(scheme: Scheme, view: Delayed) -> str:
    """Return why mean-square stability cannot be asked for, or an empty string."""
    if scheme.law.clip:
        return "its clipped increments have no simple variance"
    if not is_autonomous(view):
        return "its coefficients depend on time"
    if not limits(scheme, view, view.delay / 4.0):
        return "a step is linear neither at small states nor at large ones"
    return why_not_lasting_step(scheme, view, view.delay / 4.0)


def delay_stability(
    scheme: Scheme, view: Delayed, step_sizes: Sequence[float], scale: float, *, scan: bool = True
) -> StabilityRecord:
    """Return the spectral radius on a wide grid and at some step sizes, and where it crosses 1.

    Parameters
    ----------
    scheme : Scheme
    view : Delayed
        Of a pair that `why_not_delay_stability` has nothing against.
    step_sizes : sequence of float
    scale : float
        Size of the states at which the step is taken for linear, see `limits`.
    scan : bool
        As for `stability`.

    Returns
    -------
    StabilityRecord
        Of an equation in more than one dimension, neither growth rate nor stability are known: NaN.
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
    # Beyond the delay, bounded terms of the unknown take part in the solve: at large states that is no linear step.
    longer = np.geomspace(delay, MOST * delay, LONGER)[1:]
    parts = [shorter, np.geomspace(low, delay, count)[:-1], between, longer]
    return np.unique(np.concatenate(parts[: 3 if scale > UNIT else 4]))
