"""Base class of measures of a scalar per path, at every step size, whose mean is compared with a bound.

The number Y of a path lies between known limits, so its mean over n independent paths is compared with a bound by
Chernoff's inequality (Hoeffding 1963, Theorem 1, (2.1)): with Y scaled to [0, 1], its mean m and the bound b,

    P(mean >= m) <= exp(-n KL(m | b)) for m > b,    KL(m | b) = m ln(m/b) + (1 - m) ln((1 - m)/(1 - b)),

for any law of Y and any number of paths. A claim is

verified
    if at every step size the probability of a mean at most as large is below the level for E Y > b;
refuted
    if at some step size the probability of a mean at least as large is below the level, corrected for the number of
    step sizes, for E Y <= b;
inconclusive
    otherwise.

The number of a lost path is unknown: the upper limit is used for verification, the lower limit for
refutation.
"""

from collections.abc import Container, Iterator, Mapping, Sequence
from math import inf, log
from typing import ClassVar, NamedTuple

import numpy as np

from ..arrays import Array, Parts
from ..contracts.claimed import Bound
from ..contracts.finding import Finding, Judgement, LevelFinding, Method, Opinion, Reason, Verdict
from ..contracts.measure import Evidence, Measure, Snapshot
from ..contracts.scheme import Claim
from ..contracts.settings import Settings
from ..contracts.tally import Tally
from ..forms import Problem
from ..numerics.statistics import Estimate, chernoff, chernoff_interval, group_sums, jackknife
from ..verdicts.coverage import coverage
from ..verdicts.opinions import decide, finding, judge_claim
from ..verdicts.path_tests import PathTests, unknown_value

NUMBERS = "numbers"
METHOD = Method("paths", 3)


class ScalarMeasure(Measure):
    """Base of measures of a scalar per path: a subclass sets `name`, `value_of` and `number`.

    A scheme claims that the mean is at most b at every step size of the run by
    ``Claim(measure=name, value=value_of, bound=b, source=...)``.

    Attributes
    ----------
    value_of : str
        Meaning of the mean, such as ``share of negative paths``; also the text of claims about it.
    quantity : str
        Name of the only quantity.
    limits : tuple of float
        Range of the numbers; those beyond are clipped.
    at_end : bool
        Whether the number is evaluated at T only; by default it is the maximum over the coarsest grid, start
        included.
    """

    quantity: ClassVar[str] = "paths"
    limits: ClassVar[tuple[float, float]] = (0.0, 1.0)
    at_end: ClassVar[bool] = False
    truths: ClassVar[frozenset[str]] = frozenset()
    detail_columns: ClassVar[Mapping[str, str]] = {"h_of_largest": "step size at which the mean is largest"}
    level_columns: ClassVar[Mapping[str, str]] = {
        "ci_low": "lower end of the interval of the mean",
        "ci_high": "upper end of the interval of the mean",
    }

    def number(self, problem: Problem, t: float, parts: Parts) -> Array:
        """Return the number of each path at a time, shape (P,).

        Parameters
        ----------
        problem : Problem
        t : float
        parts : mapping of str to ndarray, shape (k, P)
            The components of the state.
        """
        raise NotImplementedError

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> "NumberObserver":
        """Return the observer of one block."""
        return NumberObserver(self, problem, parts, settings)

    def judge(self, evidence: Evidence) -> Judgement:
        """Return the finding on the mean, and the means of all levels."""
        means = _means(evidence)
        return Judgement((_finding(self, evidence, means),), _levels(self, means, evidence.settings.confidence))


class NumberObserver:
    """Accumulates the numbers of all levels, scaled to [0, 1]: at T, or their maximum so far."""

    def __init__(self, measure: ScalarMeasure, problem: Problem, parts: Parts, settings: Settings) -> None:
        self.measure, self.problem = measure, problem
        self.wanted: Sequence[Container[int]] = [frozenset()] * settings.levels
        self.h, self.step = problem.horizon / settings.coarsest, 0
        self.numbers = np.repeat(self._scaled(0.0, parts)[None], settings.levels, axis=0)

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Ignore the step, because numbers are evaluated on the coarsest grid."""

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Record the numbers of all levels."""
        self.step += 1
        now = np.stack([self._scaled(self.step * self.h, parts) for parts in snapshot.levels])
        self.numbers = now if self.measure.at_end else np.maximum(self.numbers, now)

    def tally(self) -> Tally:
        """Return sums over groups of paths."""
        paths = np.ones(self.numbers.shape[1])
        return Tally(sums={NUMBERS: group_sums(self.numbers), "paths": group_sums(paths)})

    def _scaled(self, t: float, parts: Parts) -> Array:
        low, high = self.measure.limits
        found = np.asarray(self.measure.number(self.problem, t, parts), dtype=float)
        # The number of a lost path is unknown; lost paths are counted separately.
        return np.asarray(np.clip((np.nan_to_num(found, nan=low) - low) / (high - low), 0.0, 1.0))


class ScaledMeans(NamedTuple):
    """Means of numbers scaled to [0, 1], from coarse to fine.

    Attributes
    ----------
    h : ndarray, shape (L,)
    mean, lost : ndarray, shape (L,)
        The mean, and the fraction of lost paths.
    errors : tuple of Estimate
        The means with their standard errors.
    paths : int
    """

    h: Array
    mean: Array
    lost: Array
    errors: tuple[Estimate, ...]
    paths: int

    @property
    def most(self) -> Array:
        """The means if each lost path had the upper limit."""
        return np.asarray(np.minimum(1.0, self.mean + self.lost))

    @property
    def least(self) -> Array:
        """The means if each lost path had the lower limit."""
        return np.asarray(np.maximum(0.0, self.mean - self.lost))


def _means(evidence: Evidence) -> ScaledMeans:
    sums, counts = evidence.tally.sums[NUMBERS], evidence.tally.sums["paths"]
    levels = sums.shape[1]
    lost = np.asarray(evidence.health.sums["lost"][:levels], dtype=float) / evidence.paths
    errors = tuple(jackknife(sums[:, level], counts, float) for level in range(levels))
    h = np.array(evidence.step_sizes)[:levels]
    return ScaledMeans(h, sums.sum(axis=0) / evidence.paths, lost, errors, evidence.paths)


def _unscaled(measure: ScalarMeasure, share: float) -> float:
    low, high = measure.limits
    return low + share * (high - low)


def _finding(measure: ScalarMeasure, evidence: Evidence, means: ScaledMeans) -> Finding:
    covered, worst = coverage(evidence, measure.name, measure.quantity), int(means.most.argmax())

    def judge(claim: Claim) -> Opinion:
        if not (isinstance(claim.value, Bound) and claim.value.share == 1.0):
            return Opinion(Verdict.INCONCLUSIVE, unknown_value(claim))
        return decide(_tests(measure, evidence, means, claim.value), evidence)

    ends = chernoff_interval(float(means.mean[worst]), means.paths, evidence.settings.confidence)
    return finding(
        covered,
        judge_claim(covered, judge, {measure.value_of}),
        estimate=_unscaled(measure, float(means.mean[worst])),
        low=_unscaled(measure, ends[0]),
        high=_unscaled(measure, ends[1]),
        method=METHOD,
        details={"h_of_largest": float(means.h[worst])},
    )


def _tests(measure: ScalarMeasure, evidence: Evidence, means: ScaledMeans, claimed: Bound) -> PathTests:
    low, high = measure.limits
    bound = float(np.clip((claimed.most - low) / (high - low), 0.0, 1.0))
    above = np.where(means.least > bound, chernoff(means.least, bound, means.paths), 1.0)
    below = np.where(means.most < bound, chernoff(means.most, bound, means.paths), 1.0)
    worst = int(means.most.argmax())
    told = {"value": _unscaled(measure, float(means.mean[worst])), "h": means.h[worst], "most": claimed.most}
    reason = Reason(f"{measure.value_of} {{value:.3g}} at h = {{h:.3g}}, at most {{most:g}} claimed", numbers=told)
    if means.lost.any():
        share = {"share": 100.0 * means.lost.max()}
        reason = reason.then(Reason("{share:.2g} % of the paths are lost and count either way", numbers=share))
    refuted = min(1.0, len(above) * float(above.min()))
    tests = PathTests(float(below.max()), refuted, reason, _growth(below, above, evidence.level))
    return tests.unless_vacuous(claimed.most, high)


def _growth(below: Array, above: Array, level: float) -> float:
    """Return the factor by which the paths must grow to decide; p-values are exponential in their number."""
    # To refute, the smallest p-value over the step sizes is multiplied by their number.
    tests = ((float(below.max()), level), (float(above.min()), level / len(above)))
    return min((max(1.0, log(enough) / log(p)) if p else 1.0 for p, enough in tests if p < 1.0), default=inf)


def _levels(measure: ScalarMeasure, means: ScaledMeans, confidence: float) -> Iterator[LevelFinding]:
    width = measure.limits[1] - measure.limits[0]
    for level, (mean, found) in enumerate(zip(means.mean, means.errors, strict=True)):
        ends = chernoff_interval(float(mean), means.paths, confidence)
        details = {name: _unscaled(measure, end) for name, end in zip(("ci_low", "ci_high"), ends, strict=True)}
        yield LevelFinding(measure.quantity, level, _unscaled(measure, float(mean)), width * found.se, details)
