"""Bounded moments: E max_k V(X_k), V = 1 + |x|_*^4, over the coarsest grid at every step size.

One claim is supported:

``bounded``
    uniformly in h (Lindner & Stroot 2017, Lemma 4.12).

No sample shows that a moment is finite, because paths too rare to be drawn may dominate it, and because it does not
cover smaller h. Therefore a claim is

verified
    by one step alone (T1): if sup_x log(E V(Phi(x, h, w))/V(x))/h over states near and far is bounded as h tends
    to 0, moments are bounded uniformly by iteration; see `semi_stability`. It is sufficient, not necessary. The paths
    guard it. If the map cannot be probed, they decide, unless their tails are heavy;
refuted
    by paths: the fourth root of the moment is provably more than twice that of the solution at some step size. By
    Markov's inequality a share of at most c E V / v of the paths has V >= v if the scheme's moment is at most c times
    the solution's, c = 2^4. Shares are compared with this by the binomial law, for any tail. The solution's moment
    enters with its upper confidence bound, on half of the level; thresholds and levels share the other half;
inconclusive
    otherwise.

Only cells with a claim are sampled.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
import scipy

from sdaeverify import Array, Parts, Problem, Scheme, Settings, hookimpl
from sdaeverify.measuring import (
    Estimate,
    Evidence,
    Finding,
    Judgement,
    LevelFinding,
    Measure,
    Method,
    Opinion,
    PathTests,
    Reason,
    Snapshot,
    Tally,
    Verdict,
    coverage,
    finding,
    group_sums,
    guard,
    jackknife,
    judge_claim,
    local_doubt,
    local_opinion,
    packed,
    unpacked,
    why_not_claimed,
    with_sample,
)
from sdaeverify.numerics import Tail
from sdaeverify.probing import OneStep, why_not_resolved

from .semi_stability import POWER, Growth, growth, lyapunov

# Observer of the moments measure: the largest V of each path over the coarsest grid, at every level.


# Histogram of log2 V in quarters, so that shares above any bound can be merged over blocks; infinity is in the last
# bin.
EDGES = np.arange(0.0, 256.25, 0.25)
# Number of largest values recorded per block, for tail diagnostics.
NOTED = 128


class MomentObserver:
    """Accumulates max_k V(X_k) of each level and, in the last row, of the truth; NaN if it lacks a component of V."""

    def __init__(self, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.problem, self.settings = problem, settings
        self.wanted: Sequence[frozenset[int]] = [frozenset()] * settings.levels
        self.names = problem.norm_parts or tuple(parts)
        self.worst = np.repeat(self._V(parts)[None], settings.levels + 1, axis=0)

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Ignore the step, because moments are evaluated on the coarsest grid."""

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Update the maximum."""
        now = [self._V(parts) for parts in (*snapshot.levels, snapshot.truth)]
        self.worst = np.maximum(self.worst, np.stack(now))

    def tally(self) -> Tally:
        """Return sums over groups of V and V^2, histograms and the largest values."""
        V = self.worst
        sums = {
            "paths": group_sums(np.ones(V.shape[1])),
            "moment": np.moveaxis(group_sums(np.stack([V, V * V])), 1, -1),
            "histogram": np.stack([_histogram(values) for values in V]),
        }
        return Tally(sums=sums, largest={"V": np.sort(V)[..., ::-1][..., :NOTED]})

    def _V(self, parts: Parts) -> Array:
        if not all(name in parts for name in self.names):
            return np.full(next(iter(parts.values())).shape[-1], np.nan)
        return lyapunov(self.problem, {name: parts[name] for name in self.names})


def _histogram(V: Array) -> Array:
    finite = np.where(np.isnan(V), np.inf, V)
    return np.histogram(np.clip(np.log2(finite), EDGES[0], EDGES[-1]), EDGES)[0].astype(float)


QUANTITY, BOUNDED = "moment", "bounded"
PROBED = "growth"
# A bounded rate has the local exponent 0 in 1/h; an unbounded one at least 1/2.
GROWS = 0.25
METHODS = {1: Method("growth in one step", 1), 3: Method("largest V along paths", 3)}
# c = 2^4: a moment is too large if its fourth root is more than twice the solution's.
FACTOR = 2.0**POWER
# Octaves above c E V at which shares are compared.
OCTAVES = np.array([0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0])


class Moments(Measure):
    """Fourth moments of the components, uniformly in the step size."""

    name: ClassVar[str] = "moments"
    value_of: ClassVar[str] = "ratio of moments"
    detail_columns: ClassVar[Mapping[str, str]] = {
        "class": "meaning of the value",
        "h_of_largest": "step size at which the ratio is largest",
        "growth_rate": "growth rate of the moment in one step, per unit of time",
    }
    level_columns: ClassVar[Mapping[str, str]] = {
        "ratio": "moment of the scheme over that of the solution",
        "hill": "tail index by Hill's estimator",
        "largest_share": "share of the moment due to the largest path",
    }

    def refuses(self, scheme: Scheme, problem: Problem) -> str:
        """Return why the measure does not apply: no claim, so that no paths are sampled for the scheme."""
        return why_not_claimed(scheme, problem, self.name)

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> MomentObserver:
        """Return the observer of one block."""
        return MomentObserver(problem, parts, settings)

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:
        """Return the growth of E V in one step, if the map can be probed."""
        return Tally() if OneStep(scheme, view).why_not_probed() else packed(PROBED, growth(scheme, view))

    def judge(self, evidence: Evidence) -> Judgement:
        """Return one finding, and the moments of all levels."""
        sample = LargestValues.of(evidence)
        return Judgement((_finding(evidence, sample),), tuple(_levels(sample)))


@hookimpl
def sdaeverify_measures() -> list[Measure]:
    """Register the measure."""
    return [Moments()]


class LargestValues(NamedTuple):
    """The largest V of each path at L levels, and of the truth in the last row.

    Attributes
    ----------
    h : ndarray, shape (L,)
    counts : ndarray, shape (G,)
    sums : ndarray, shape (G, L + 1, 2)
        Of V and V^2 over groups.
    histogram : ndarray, shape (L + 1, bins)
    largest : ndarray, shape (L + 1, k)
    """

    h: Array
    counts: Array
    sums: Array
    histogram: Array
    largest: Array

    @classmethod
    def of(cls, evidence: Evidence) -> "LargestValues":
        """Return the sample of a cell."""
        sums = evidence.tally.sums
        h, top = np.array(evidence.step_sizes), evidence.tally.largest["V"][..., : evidence.settings.extremes]
        return cls(h, sums["paths"], sums["moment"], sums["histogram"], top)

    @property
    def paths(self) -> int:
        """Number of paths."""
        return int(self.counts.sum())

    def moment(self, row: int) -> Estimate:
        """Return E max_k V of a level, or of the truth."""
        return jackknife(self.sums[:, row, 0], self.counts, float)

    def log_ratio(self, level: int) -> Estimate:
        """Return log2 of a level's moment over that of the truth."""
        return jackknife(self.sums[:, [level, -1], 0], self.counts, lambda m: float(np.log2(m[0] / m[1])))

    def tail(self, row: int) -> Tail:
        """Return the tail diagnostics of a level, or of the truth."""
        total, squares = self.sums[:, row].sum(axis=0)
        return Tail.of(float(total), float(squares), self.largest[row], self.paths)

    def excess(self, bound: float) -> Array:
        """Return, by level and threshold, the probability of at least the observed exceedances if E V <= bound."""
        above = np.cumsum(self.histogram[:-1, ::-1], axis=1)[:, ::-1]
        places = np.searchsorted(EDGES[:-1], np.log2(bound) + OCTAVES).clip(max=len(EDGES) - 2)
        hits, share = above[:, places], np.minimum(1.0, bound / 2.0 ** EDGES[places])
        return np.where(hits > 0.0, scipy.special.bdtrc(hits - 1.0, self.paths, share), 1.0)


def _finding(evidence: Evidence, sample: LargestValues) -> Finding:
    covered = coverage(evidence, Moments.name, QUANTITY)
    ratios = [sample.log_ratio(level) for level in range(len(sample.h))]
    worst = int(np.argmax([ratio.value for ratio in ratios]))
    low, high = ratios[worst].interval(evidence.settings.confidence)
    found = unpacked(PROBED, Growth, evidence.tally)
    local = judge_growth(found, evidence.view.horizon) if found else None
    opinion = judge_claim(
        covered, lambda _: guard(local, _tests(evidence, sample, ratios, local), evidence), {BOUNDED}
    )
    return finding(
        covered,
        opinion,
        estimate=float(2.0 ** ratios[worst].value),
        low=float(2.0**low),
        high=float(2.0**high),
        method=METHODS[opinion.tier],
        details={
            "class": "ratio of moments",
            "h_of_largest": float(sample.h[worst]),
            "growth_rate": float(found.rate.max()) if found else np.nan,
        },
    )


def judge_growth(found: Growth, horizon: float) -> Opinion:
    """Judge whether the rates are bounded as h tends to 0: verified or open, because boundedness is not necessary.

    Rates below 1/horizon count as 1/horizon, because such growth is not noticeable within the horizon.
    """
    rate, size = np.maximum(found.rate, 1.0 / horizon), found.far
    worst = int(found.rate.argmax())
    figures = f"at most exp({found.rate[worst]:.3g} h) at all {int(found.states)} states"
    if not np.isfinite(rate).all():
        text = f"one step has no root, or E[V] is infinite, at h = {found.h[worst]:.3g} where V = {size[worst]:.3g}^4"
        return local_doubt(f"{text}: samples miss the contribution of rare paths")
    exponent = np.log(rate[-1] / rate[-2]) / np.log(found.h[-2] / found.h[-1])
    if exponent > GROWS:
        text = f"E[V] grows by exp(c h) in one step, c ~ h^-{exponent:.2f}, where V = {size[-1]:.3g}^4"
        return local_doubt(f"{text}: samples miss the contribution of rare paths")
    return local_opinion(Verdict.VERIFIED, f"E[V] grows in one step by {figures}: bounded as h tends to 0")


def _tests(evidence: Evidence, sample: LargestValues, ratios: list[Estimate], local: Opinion | None) -> PathTests:
    truth = sample.moment(-1)
    if not np.isfinite(truth.se) or sample.tail(-1).heavy:
        return PathTests.none("the moment of the exact solution is unknown, or dominated by few paths")
    bound = FACTOR * truth.interval(1.0 - evidence.level)[1]
    # A statement for h -> 0 is not tested on steps that do not resolve the problem's fastest time.
    resolved = np.array([not why_not_resolved(evidence.view, h) for h in sample.h])
    excess = np.where(resolved[:, None], sample.excess(bound), 1.0)
    level = int(excess.min(axis=1).argmin())
    refuted = min(1.0, max(evidence.level, 2.0 * excess.size * float(excess.min())))
    suspect = refuted <= 1.0 - evidence.settings.confidence
    verified, reason, growth = _from_below(evidence, sample, ratios, local)
    if suspect:
        far = f"more paths are large at h = {sample.h[level]:.3g} than {FACTOR:g} times the exact moment"
        reason, growth = Reason.of(f"{far} allows", _size(ratios[level])), 1.0
    return with_sample(PathTests(verified, refuted, reason, growth), sample.paths, heavy=False)


def _from_below(
    evidence: Evidence, sample: LargestValues, ratios: list[Estimate], local: Opinion | None
) -> tuple[float, Reason, float]:
    """Return the p-value against too large moments, the figures, and the growth of the sample to decide."""
    p_values = [ratio.p_below(np.log2(FACTOR)) for ratio in ratios]
    worst = int(np.argmax(p_values))
    reason = _size(ratios[worst])
    if why := why_not_resolved(evidence.view, sample.h[worst]):
        return 1.0, reason.then(why), np.inf
    if evidence.health.sums["without_root"].any():
        return 1.0, reason.then("steps without root"), np.inf
    if local is not None or any(sample.tail(level).heavy for level in range(len(ratios))):
        # A sample does not confirm a claim that one step leaves open, or moments dominated by few paths.
        return 1.0, reason, np.inf
    return p_values[worst], reason, ratios[worst].growth_to_decide(np.log2(FACTOR), evidence.level)


def _size(ratio: Estimate) -> Reason:
    return Reason("moment {ratio:.3g} times the exact one", numbers={"ratio": 2.0**ratio.value})


def _levels(sample: LargestValues) -> Iterator[LevelFinding]:
    for level in range(len(sample.h)):
        moment, ratio, found = sample.moment(level), sample.log_ratio(level), sample.tail(level)
        details = {"ratio": float(2.0**ratio.value), "hill": found.hill, "largest_share": found.share}
        yield LevelFinding(QUANTITY, level, moment.value, moment.se, details)
