"""Constraint drift: violation of the constraint and the hidden constraint, and its dependence on h and t.

The supremum over time of the root mean square of |g| is classified against h:

``round-off``
    at most 64 eps scale sqrt(N) at every level, on every path;
``tolerance-limited``
    independent of h (|slope| < 0.35) and below 1e-3 of the scale: a solver's tolerance;
``order p``
    slope p >= 0.35, with the jackknife interval and the growth exponent in time;
``growing``
    slope <= -0.35: errors accumulate as h tends to 0, always flagged;
``constant``
    independent of h and not small.

The residual of a constraint that the solution satisfies is bounded by the error of the solution, up to its Lipschitz
constant. So if one step shows a strong order of the whole state in L2, the residual has this order, too, guarded by
paths. Otherwise the order of the residual along paths decides.

The mean over paths of (int_0^T |g|^2 dt)^{1/2} is reported as well. On a chain of nodes with spacing ds, where
g = (1 - |d_s r|^2)/2 on each edge, the norms over space and time of Lindner et al. (2018), Fig. 4.3, are 2 sqrt(ds)
times that of g for |d_s r|^2 - 1 = -2 g, and sqrt(ds) times that of Dg v for d_s r . d_s v = -Dg v.

The largest defects and their growth are taken at times evenly spaced in their logarithm. Few of these are late, so
integrals over time use other times: one in each of 64 equal stretches.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, Parts
from ..contracts.claimed import ROUND_OFF, Exact, Order, bar
from ..contracts.finding import Finding, Judgement, Kind, LevelFinding, Method, Opinion, Reason, Verdict
from ..contracts.measure import Evidence, Measure, Snapshot
from ..contracts.scheme import Claim, Scheme
from ..contracts.settings import Settings
from ..contracts.tally import Tally
from ..forms import Delayed, Problem
from ..numerics import norm
from ..numerics.digits import SAMPLED, significant
from ..numerics.statistics import (
    EPS,
    HEAVY,
    RISING,
    Estimate,
    estimates,
    group_sums,
    jackknives,
    leave_out,
    slope_weights,
)
from ..probe.local.orders import FLAT
from ..registry.hookspecs import hookimpl
from ..simulate.tracks import HELD
from ..verdicts.coverage import Coverage, claim_for, coverage
from ..verdicts.fitted_levels import FEWEST, FITTED, sound_levels_of
from ..verdicts.opinions import diverged, finding, guard, no_fit
from ..verdicts.path_tests import (
    SUSPECT,
    PathTests,
    hold_back,
    order_resolution,
    order_tests,
    resolve_order,
    with_sample,
)
from .path_errors.errors import STATE
from .residuals import judge_ratios, rounding_ratios
from .slopes import Slopes
from .strong.findings import TOLERANCE, judge_order, local_orders, probe_strong

METHODS = {
    1: Method("local strong order", 1, guard="the residual along paths"),
    3: Method("order of the residual along paths", 3),
}
# Size: number of times at which the growth of a defect is evaluated.
TIMES = 64
# Theorem: its multiples are evenly distributed (three gaps, Sos 1958), for any period of a scheme.
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
# Size: a histogram of log2 |defect| in eighths, so that quantiles of merged blocks are known to 4.5 per cent.
BINS_PER_OCTAVE = 8
# Size: residuals from 2^-64 to 2^32.
LOWEST, HIGHEST = -64, 32
EDGES = np.arange(LOWEST * BINS_PER_OCTAVE, HIGHEST * BINS_PER_OCTAVE + 1) / BINS_PER_OCTAVE
# Texts of classes for reasons; an order is given by its number.
CLASSES = {
    "tolerance-limited": "at a solver's tolerance",
    "growing as h tends to 0": "growing as h falls",
}
ROUNDED = "largest residual {largest:.1g}, within the bound {bound:.1g} for round-off"
NEAR_ROOTLESS = (
    "largest residual {largest:.1g}, beyond round-off ({bound:.1g}) only at step sizes where paths have no root"
)
# Theorem: the defect of a step with random parts is a series in powers of h^(1/2).
NEXT_POWER = 0.5


def log_spaced(steps: int) -> list[int]:
    """Return at most 64 step numbers between 1 and `steps`, evenly spaced in their logarithm."""
    return sorted({round(step) for step in np.geomspace(1, steps, min(TIMES, steps))})


def quadrature(steps: int) -> dict[int, float]:
    """Return step numbers with weights of sum 1 - 1/(2 steps): the trapezoidal rule on (0, 1] for f(0) = 0.

    Up to 64 steps all of them are used, with half a step for the last one. Of more, 64 equal stretches have one each,
    at places that jump by the golden ratio, so that a defect that is reset every few steps is sampled at all phases.

    Parameters
    ----------
    steps : int

    Returns
    -------
    dict of int to float
    """
    ends = np.round(np.linspace(0, steps, min(TIMES, steps) + 1)).astype(int)
    sizes, places = np.diff(ends), (GOLDEN * np.arange(1, len(ends))) % 1.0
    weights = sizes / steps
    weights[-1] -= 0.5 / steps
    chosen = ends[:-1] + 1 + np.floor(places * sizes).astype(int)
    return dict(zip(chosen.tolist(), weights.tolist(), strict=True))


class ResidualObserver:
    """Accumulates |g| at wanted steps: sums of squares over groups, the maximum, and each path's largest value.

    Also (int_0^T |g|^2 dt)^{1/2} of each path, g being 0 at the start. Paths held without a root are excluded,
    because the constraint may move away from them. They count as failed, which prevents verification.
    """

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.problem = problem
        self.times = [log_spaced(steps) for steps in settings.steps]
        self.noted = [frozenset(times) for times in self.times]
        self.weights = [quadrature(steps) for steps in settings.steps]
        self.wanted: Sequence[frozenset[int]] = [
            times.union(weights) for times, weights in zip(self.noted, self.weights, strict=True)
        ]
        residuals = problem.residuals(parts)
        self.names = list(residuals)
        self.paths = next(iter(residuals.values())).value.shape[-1]
        self.squares: dict[str, list[list[Array]]] = {name: [[] for _ in self.times] for name in self.names}
        self.worst = {name: np.zeros((settings.levels, self.paths)) for name in self.names}
        self.scale = {name: np.zeros(settings.levels) for name in self.names}
        self.integral = {name: np.zeros((settings.levels, self.paths)) for name in self.names}

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Accumulate the defects after one of the wanted steps."""
        for name, residual in self.problem.residuals(parts).items():
            size = norm(residual.value)
            if HELD in parts:
                size = np.where(parts[HELD][0] > 0.0, 0.0, size)
            square = size * size
            if step in self.weights[level]:
                self.integral[name][level] += self.problem.horizon * self.weights[level][step] * square
            if step in self.noted[level]:
                self.squares[name][level].append(group_sums(square))
                self.worst[name][level] = np.fmax(self.worst[name][level], size)
                self.scale[name][level] = np.fmax(self.scale[name][level], np.fmax.reduce(residual.scale))

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Ignore the snapshot, because defects are accumulated at each level's own times."""

    def tally(self) -> Tally:
        """Return the sums of squares by group and time, of norms in time, histograms, maxima and scales."""
        sums: dict[str, Array] = {"paths": group_sums(np.ones(self.paths))}
        maxima: dict[str, Array] = {}
        for name in self.names:
            for level, squares in enumerate(self.squares[name]):
                sums[f"squares {name} {level}"] = significant(np.stack(squares, axis=-1), SAMPLED)
            sums[f"l2 {name}"] = significant(group_sums(np.sqrt(self.integral[name])), SAMPLED)
            sums[f"histogram {name}"] = np.stack([_histogram(worst) for worst in self.worst[name]])
            maxima[f"worst {name}"] = self.worst[name].max(axis=-1)
            maxima[f"scale {name}"] = self.scale[name]
        return Tally(sums=sums, maxima=maxima)


def quantile(histogram: Array, q: float) -> float:
    """Return the q-quantile of a histogram of log2 values, as the geometric mean of its bin's edges."""
    total = histogram.sum()
    if total == 0.0:
        return float("nan")
    index = int(np.searchsorted(np.cumsum(histogram), q * total))
    return float(2.0 ** (0.5 * (EDGES[index] + EDGES[index + 1])))


def effective_share(histogram: Array) -> float:
    """Return (sum e^2)^2 / (M sum e^4) from a histogram of log2 e: the effective share of paths in a mean square."""
    squares = 2.0 ** (EDGES[:-1] + EDGES[1:])
    total = histogram.sum()
    fourth = total * (histogram @ squares**2)
    return float((histogram @ squares) ** 2 / fourth) if fourth > 0.0 else 1.0


def _histogram(values: Array) -> Array:
    with np.errstate(divide="ignore"):
        clipped = np.clip(np.log2(values[np.isfinite(values)]), EDGES[0], EDGES[-1])
    return np.histogram(clipped, EDGES)[0].astype(float)


@dataclass(frozen=True)
class Defect(Slopes):
    """The evidence on one constraint.

    Attributes
    ----------
    name : str
    h : ndarray, shape (L,)
    squares : tuple of ndarray, shape (G, times of the level)
        Sums of |g|^2 over groups.
    counts : ndarray, shape (G,)
    histogram : ndarray, shape (L, bins)
        Of each path's largest |g|.
    worst, scale : ndarray, shape (L,)
        Largest |g| over all paths and times, and the size of the terms that cancel in it.
    l2 : ndarray, shape (G, L)
        Sums of (int_0^T |g|^2 dt)^{1/2} over groups.
    """

    next_power: ClassVar[float] = NEXT_POWER
    name: str
    h: Array
    squares: tuple[Array, ...]
    counts: Array
    histogram: Array
    worst: Array
    scale: Array
    l2: Array

    def find_logarithms(self) -> Array:
        """Return log2 of sup_t RMS |g| over all paths and without each group."""
        left_out = (leave_out(squares, self.counts) for squares in self.squares)
        return np.stack([0.5 * np.log2(means.max(axis=-1)) for means in left_out], axis=1)

    @property
    def sup_rms(self) -> tuple[Estimate, ...]:
        """log2 of sup_t RMS |g| at each level."""
        return estimates(self.logarithms)

    def linear(self, levels: Array, weights: Array) -> Estimate:
        """Return sum_l w_l y_l over the given levels."""
        terms = (w * self.logarithms[:, level] for w, level in zip(weights, levels.tolist(), strict=True))
        return estimates(np.asarray(sum(terms)))[0]

    def growth(self, level: int, times: Array) -> float:
        """Return the slope of log RMS against log t over the second half of the log-time axis."""
        late = times**2 >= times[0] * times[-1]
        rms = np.sqrt(self.squares[level].sum(axis=0) / self.counts.sum())
        if np.count_nonzero(late) < 3 or not (rms[late] > 0.0).all():
            return float("nan")
        return float(slope_weights(np.log2(times[late])) @ np.log2(rms[late]))


class Drift(Measure):
    """Violation of each constraint along the paths."""

    name: ClassVar[str] = "drift"
    truths: ClassVar[frozenset[str]] = frozenset()
    detail_columns: ClassVar[Mapping[str, str]] = {
        "class": "behaviour of the residual as h tends to 0",
        "std_error": "standard error of the order",
        "growth": "power of t with which the residual grows at the finest step size",
        "fitted_levels": "levels that the order is fitted to",
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "l2": "mean over paths of the L2 norm in time of the residual",
        "l2_std_error": "its standard error",
        "max": "largest residual of all paths and times",
        "median": "median over paths of the largest residual",
        "q99": "quantile 0.99 over paths of the largest residual",
        "scale": "size of the terms that cancel in the residual",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no constraint, or a view in which it is eliminated."""
        if not problem.has_constraints:
            return "the problem has no constraint"
        view = scheme.view_of(problem)
        eliminated = "algebraic" in problem.traits and view is not None and view is not problem
        return "the scheme sees the equation with y eliminated: no constraint is left" if eliminated else ""

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> ResidualObserver:
        """Return the observer of one block."""
        return ResidualObserver(problem, parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the local defects if an order is claimed and the one-step map can be probed."""
        asked = (claim for claim in scheme.promises if claim.measure == self.name and claim.when <= view.traits)
        if view.capability(Delayed) or not any(isinstance(claim.value, Order) for claim in asked):
            return Tally()
        return probe_strong(scheme, view, settings)

    def judge(self, evidence: Evidence) -> Judgement:
        """Return a finding for each constraint, and its levels."""
        defects = _defects(evidence)
        findings = tuple(_finding(evidence, defect) for defect in defects)
        return Judgement(findings, tuple(row for defect in defects for row in _levels(defect)))

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:
        """Yield a finding for each constraint that is claimed to hold up to round-off, from single steps."""
        if not view.has_constraints:
            return
        ratios = rounding_ratios(scheme, view)
        for name in ratios:
            covered = claim_for(scheme, view.traits, self.name, name)
            if covered.claim is not None and isinstance(covered.claim.value, Exact):
                yield finding(covered, judge_ratios(ratios[name]), method=Method("residual of one step", 1))


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Drift()]


def _defects(evidence: Evidence) -> tuple[Defect, ...]:
    return evidence.along_paths.read(_read_defects, *evidence.step_sizes)


def _read_defects(tally: Tally, *step_sizes: float) -> tuple[Defect, ...]:
    sums, maxima = tally.sums, tally.maxima
    return tuple(
        Defect(
            name=name,
            h=np.array(step_sizes),
            squares=tuple(sums[f"squares {name} {level}"] for level in range(len(step_sizes))),
            counts=sums["paths"],
            histogram=sums[f"histogram {name}"],
            worst=maxima[f"worst {name}"],
            scale=maxima[f"scale {name}"],
            l2=sums[f"l2 {name}"],
        )
        for name in (key.removeprefix("histogram ") for key in sums if key.startswith("histogram "))
    )


def _finding(evidence: Evidence, defect: Defect) -> Finding:
    covered = coverage(evidence, Drift.name, defect.name)
    levels, remarks = sound_levels_of(evidence)
    # A path held without a root on a constraint of the state alone has no residual; its last residual counts.
    bound = 64.0 * EPS * defect.scale * np.sqrt(evidence.settings.steps)
    beyond = defect.worst > bound
    if not beyond.any():
        found = _round_off(evidence, defect, covered, _largest(defect, bound))
    elif covered.claim is not None and isinstance(covered.claim.value, Exact):
        # Near paths without a root the derivative of the constraint is nearly singular, so a root is less accurate.
        rootless = evidence.health.sums["failed"] > 0
        known = _beyond_round_off(defect, covered, bound)
        found = (
            known
            if beyond[~rootless].any()
            else _round_off(evidence, defect, covered, _largest(defect, bound, NEAR_ROOTLESS))
        )
    elif len(levels) < FEWEST:
        return finding(covered, no_fit(evidence, covered, remarks), method=Method("paths"))
    else:
        found = _of_slope(evidence, defect, levels[-FITTED - 1 :], covered)
    return replace(found, reason=Reason.of(found.reason, remarks, covered.gap))


def _largest(defect: Defect, bound: Array, text: str = ROUNDED) -> Reason:
    largest = int(np.nanargmax(defect.worst))
    return Reason(text, numbers={"largest": float(defect.worst[largest]), "bound": float(bound[largest])})


def _round_off(evidence: Evidence, defect: Defect, covered: Coverage, reason: Reason) -> Finding:
    # An exact constraint satisfies a claim of any order, but only if every step succeeded.
    health = evidence.health.sums
    verdict = Verdict.INCONCLUSIVE if health["failed"].any() else Verdict.VERIFIED
    opinion = Opinion(Verdict.OUT_OF_SCOPE, reason)
    if covered.claim:
        opinion = diverged(Opinion(verdict, reason), health["lost"][-1])
    return _of_largest(defect, covered, opinion, ROUND_OFF)


def _beyond_round_off(defect: Defect, covered: Coverage, bound: Array) -> Finding:
    level = int(np.nanargmax(defect.worst / bound))
    text = f"residual {defect.worst[level]:.2g} at h = {defect.h[level]:.3g}, bound for round-off {bound[level]:.2g}"
    kind = _classify(defect.slope(np.arange(len(defect.h))).value, defect.worst[-1], defect.scale[-1])
    reason = Reason.of(text, CLASSES.get(kind, f"{kind} as h falls"))
    return _of_largest(defect, covered, Opinion(Verdict.REFUTED, reason), kind)


def _of_largest(defect: Defect, covered: Coverage, opinion: Opinion, kind: str) -> Finding:
    largest, what = float(np.fmax.reduce(defect.worst)), "largest residual"
    method = Method(f"{what} along paths", 3)
    return finding(covered, opinion, estimate=largest, value_of=what, method=method, details={"class": kind})


def _of_slope(evidence: Evidence, defect: Defect, sound: Array, covered: Coverage) -> Finding:
    levels = sound[-FITTED:]
    slope = defect.slope(levels)
    low, high = slope.interval(evidence.settings.confidence)
    sup = 2.0 ** defect.sup_rms[levels[-1]].value
    kind = _classify(slope.value, sup, defect.scale[levels[-1]])
    growth = defect.growth(levels[-1], np.array(log_spaced(evidence.settings.steps[levels[-1]]), dtype=float))
    opinion, order_seen = Opinion(Verdict.OUT_OF_SCOPE), np.nan
    if covered.claim is not None:
        local, tests = _of_state(evidence, covered.claim), _tests(evidence, defect, covered.claim, sound)
        if local is None and isinstance(covered.claim.value, Order):
            share = defect.lower_share(sound, covered.claim.value.least)
            order_seen = order_resolution(share, evidence.settings.confidence)
            tests = resolve_order(tests, covered.claim.value, share, evidence)
        opinion = guard(local, tests, evidence)
    told = "" if opinion.reason.has(Kind.ORDER) else f"along paths: {CLASSES.get(kind, f'order {slope.value:.2f}')}, "
    size = f"residual {told}{sup:.2g} at the finest h, grows as t^{growth:.1f}"
    return finding(
        covered,
        opinion.plus(size),
        estimate=slope.value,
        low=low,
        high=high,
        order_resolution=order_seen,
        method=METHODS[opinion.tier],
        details={
            "class": kind,
            "std_error": slope.se,
            "growth": growth,
            "fitted_levels": len(levels),
            **_order_of_state(evidence),
        },
    )


def _order_of_state(evidence: Evidence) -> dict[str, object]:
    """Return the local order of the whole state, a lower bound of the residual's if verified; empty if unknown."""
    order = local_orders(evidence).get(STATE)
    return {} if order is None else {"local_order": order.order}


def _of_state(evidence: Evidence, claim: Claim) -> Opinion | None:
    """Return the opinion that one step verifies the order for the whole state, hence for a constraint, or None."""
    local = judge_order(evidence, claim, local_orders(evidence).get(STATE))
    if local is None or local.verdict is not Verdict.VERIFIED:
        return None
    order, claimed = local_orders(evidence)[STATE].order, claim.value
    assert isinstance(claimed, Order)
    known = "residual without error beyond round-off" if np.isinf(order) else f"residual order at least {order:.2f}"
    told = f"{known} from one step"
    return local._replace(reason=Reason(f"{told}; {bar(claimed.least, claimed.least - TOLERANCE)}"))


def _classify(slope: float, sup: float, scale: float) -> str:
    if not np.isfinite([slope, sup]).all():
        return "not finite"
    if slope >= FLAT:
        return f"order {slope:.2f}"
    if slope <= -FLAT:
        return "growing as h tends to 0"
    return "tolerance-limited" if sup < 1e-3 * scale else "constant"


def _tests(evidence: Evidence, defect: Defect, claim: Claim, sound: Array) -> PathTests:
    tests = _asymptotic(evidence, defect, claim, sound)
    if tests.refuted < 1.0 and defect.rise(sound).interval(evidence.settings.confidence)[0] > RISING:
        # Steps that are too coarse for the claimed order are no evidence against it.
        tests = tests.held("the order still rises", growth=tests.growth)
    share = effective_share(defect.histogram[-1])
    heavy = share < HEAVY
    if heavy and tests.refuted > 0.0:
        # With heavy tails, the interval of a root mean square refutes no claim.
        tests = tests.held(growth=tests.growth)._replace(
            reason=Reason(f"heavy tails: the mean rests on {share:.2g} of the paths").then(tests.reason)
        )
    return hold_back(with_sample(tests, evidence.paths, heavy=heavy), evidence, sound)


def _asymptotic(evidence: Evidence, defect: Defect, claim: Claim, sound: Array) -> PathTests:
    """Compare the order with the claim; on coarse steps a low order refutes only if its extrapolation is low, too."""
    tests = order_tests(claim, defect.slope(sound[-FITTED:]), evidence)
    if not isinstance(claim.value, Order) or tests.refuted > SUSPECT:
        return tests
    bound, order = claim.value.floor, defect.corrected_slope(sound)
    low, high = order.interval(evidence.settings.confidence)
    reason = tests.reason.then(Reason("[{low:.2f}, {high:.2f}] as h tends to 0", numbers={"low": low, "high": high}))
    growth = order.growth_to_decide(bound, evidence.level) if order.value < bound else np.inf
    refuted = max(tests.refuted, order.p_below(bound))
    return PathTests(tests.verified, refuted, reason, max(tests.growth, growth), suspected=tests.refuted)


def _levels(defect: Defect) -> Iterator[LevelFinding]:
    sups = defect.sup_rms
    # In Fortran order, the sums of each level are bitwise equal to those computed for this level alone.
    for level, l2 in enumerate(jackknives(np.asfortranarray(defect.l2), defect.counts, np.asarray)):
        log_rms = sups[level]
        rms = 2.0**log_rms.value
        details = {
            "l2": l2.value,
            "l2_std_error": l2.se,
            "max": float(defect.worst[level]),
            "median": quantile(defect.histogram[level], 0.5),
            "q99": quantile(defect.histogram[level], 0.99),
            "scale": float(defect.scale[level]),
        }
        yield LevelFinding(defect.name, level, rms, float(np.log(2.0) * rms * log_rms.se), details)
