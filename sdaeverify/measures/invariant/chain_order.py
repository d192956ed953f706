"""What replicated chains say of one stationary mean: the order of its bias in h, and whether its limit is exact.

All of it is taken from group means, which are independent and as good as normal, through one comparison of absolute
values of expectations. No logarithm of a noisy number is tested, so that no effect has to be resolved first.

With b_l the bias at level l of m + 2, D_l = b_l - b_{l+1}, and order p claimed, p_0 = p - margin,

    order > p_0           |D_m| < 2^(-m p_0) |D_0|
    order < p_0           |D_m| > 2^(-m p_0) |D_0|
    limit wrong           |e| > 2^(-p (m-l)) |D_l|/(2^p - 1)   for every l,     e = b_{m+1} - D_m/(2^p - 1)
    limit confirmed       |e| < |b|/4,                                          b = b_0 - e

Where the bias is c h^p, its part at the finest level is Richardson's tail D_m/(2^p - 1): e is what is left of the
mean's error, and b the bias at the coarsest level that the differences explain. The tail is granted an error of
100 %, so that a limit that is wrong by less than it is not refuted; one wrong by more than b/4 is never verified.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from ...arrays import Array
from ...contracts.claimed import Order
from ...contracts.measure import Evidence
from ...numerics.outweighed import outweighs, sample_growth, t_values
from ...numerics.statistics import EPS, RISING
from ...simulate.chains import GROUPS, ChainRecord
from ...verdicts.path_tests import RESOLVED

# What is left of a mean's error may be this part of the bias at the coarsest level.
# Chosen.
CONFIRMED = 0.25


@dataclass(frozen=True)
class BiasSample:
    """The group means of one observable at one look, on the levels that can be used.

    Attributes
    ----------
    h : ndarray, shape (L,)
    levels : ndarray, shape (K, L)
        Of the paired chains.
    coarse : ndarray, shape (K,)
        At the coarsest of these levels, from as many chains as there are.
    exact : float
    rounding : float
        What rounding can do to a mean.
    """

    h: Array
    levels: Array
    coarse: Array
    exact: float
    rounding: float

    @property
    def differences(self) -> Array:
        """D_l, shape (K, L - 1); exactly 0 where it is no larger than rounding."""
        D = self.levels[:, :-1] - self.levels[:, 1:]
        return np.asarray(np.where(np.abs(D).max(axis=0) <= self.rounding, 0.0, D))

    @property
    def errors(self) -> Array:
        """The bias at each level, shape (K, L): that of the coarsest less the paired differences."""
        gained = np.cumsum(np.insert(self.differences, 0, 0.0, axis=1), axis=1)
        return np.asarray((self.coarse - self.exact)[:, None] - gained)

    @property
    def signals(self) -> Array:
        """Mean differences in units of their standard errors, shape (L - 1,); 0 where there is none."""
        return np.array([float(t_values(D)) for D in self.differences.T])

    @property
    def resolved(self) -> bool:
        """Whether all differences are told from 0."""
        return bool(np.all(np.abs(self.signals) >= RESOLVED))

    @property
    def order(self) -> float:
        """The mean local order log2 |D_0/D_m| / m."""
        D = self.differences.mean(axis=0)
        return float(np.log2(np.abs(D[0] / D[-1])) / (len(D) - 1))

    @property
    def local_orders(self) -> Array:
        """log2 |D_l/D_{l+1}|, shape (L - 2,)."""
        D = np.abs(self.differences.mean(axis=0))
        return np.asarray(np.log2(D[:-1] / D[1:]))

    def known_errors(self, confidence: float) -> tuple[Array, Array]:
        """Return the bias at each level and the half width of its interval, both of shape (L,)."""
        t = scipy.special.stdtrit(len(self.errors) - 1, 0.5 + 0.5 * confidence)
        return self.errors.mean(axis=0), t * self.errors.std(axis=0, ddof=1) / np.sqrt(len(self.errors))

    @property
    def leading_coefficient(self) -> float:
        """The factor c in a bias c h^p with p = `order`, from the finest difference."""
        return float(self.differences[:, -1].mean() / (self.h[-2] ** self.order - self.h[-1] ** self.order))

    def order_interval(self, confidence: float) -> tuple[float, float]:
        """Return Fieller's interval of the ratio D_m/D_0, as orders: valid however noisy the differences are."""
        D = self.differences[:, [0, -1]]
        a, b = D.mean(axis=0)
        t = scipy.special.stdtrit(GROUPS - 1, 0.5 + 0.5 * confidence)
        (va, c), (_, vb) = t**2 * np.cov(D.T) / GROUPS
        spread = (a * b - c) ** 2 - (a**2 - va) * (b**2 - vb)
        if not (a**2 > va and spread >= 0.0):
            return -np.inf, np.inf
        ends = ((a * b - c) + np.array([-1.0, 1.0]) * np.sqrt(spread)) / (a**2 - va)
        m, (least, most) = self.differences.shape[1] - 1, np.sort(np.abs(ends))
        crosses_zero = ends[0] <= 0.0 <= ends[1]
        return float(-np.log2(most) / m), np.inf if crosses_zero else float(-np.log2(least) / m)

    def changes_sign(self) -> bool:
        """Tell whether two differences that are resolved have opposite signs: a leading coefficient near 0."""
        found = self.signals
        return bool((found >= RESOLVED).any() and (found <= -RESOLVED).any())

    def p_falls(self, claim: Order) -> float:
        """Return the p-value of the hypothesis that a claimed order is not reached, or not towards the exact mean."""
        D, m = self.differences, self.differences.shape[1] - 1
        faster = exceeds(2.0 ** (-m * claim.floor) * D[:, 0], D[:, -1])
        remainder = self.remainder(claim.least)
        return max(faster, exceeds(CONFIRMED * (self.errors[:, 0] - remainder), remainder))

    def remainder(self, order: float) -> Array:
        """Return what is left of the finest error if Richardson's tail for an order is taken off, shape (K,)."""
        return np.asarray(self.errors[:, -1] - self.differences[:, -1] / (2.0**order - 1.0))

    def p_slow(self, claim: Order) -> float:
        """Return the p-value of the hypothesis that the differences fall with a claimed order."""
        D, m = self.differences, self.differences.shape[1] - 1
        return exceeds(D[:, -1], 2.0 ** (-m * claim.floor) * D[:, 0])

    def is_settled(self, confidence: float) -> bool:
        """Tell whether low local orders are no matter of too coarse steps.

        There are three differences at least, all told from 0 and of the same sign, and no local order that grows with
        refinement by more than `RISING`, at a confidence: an order is not held against steps on which it still rises,
        or on which the bias passes through 0.
        """
        signs = np.sign(self.signals)
        if len(signs) < 3 or not self.resolved or np.any(signs != signs[0]):
            return False
        rise, se = self._of_last([-1.0, 2.0, -1.0])
        return bool(rise - scipy.special.stdtrit(GROUPS - 1, 0.5 + 0.5 * confidence) * se <= RISING)

    def may_reach(self, claim: Order) -> bool:
        """Tell whether the local order, if it rises once more as it did last, may be what is claimed.

        It may unless its one-sided interval at 95 per cent is below: few chains do not tell a rise from none. There
        are three differences at least, as `is_settled` wants them.
        """
        ahead, se = self._of_last([-1.0, 3.0, -2.0])
        return bool(ahead + scipy.special.stdtrit(GROUPS - 1, 0.95) * se >= claim.floor)

    def growth_to_keep(self, claim: Order, confidence: float) -> float:
        """Return the factor by which the chains must grow to show the claimed order at the finest step sizes.

        An error a h + b h^2 has a mean order near 2 as long as b h is much larger than a; its local orders fall with
        each halving of h. Shown are the order of the two finest differences and, of three or more, the next one if it
        changes by as much again: the lower ends of their one-sided intervals are claim - margin at least.

        Parameters
        ----------
        claim : Order
        confidence : float

        Returns
        -------
        float
            1 if the order is shown; infinite if more chains would not show it.
        """
        contrasts = [[1.0, -1.0], [-1.0, 3.0, -2.0]][: self.differences.shape[1] - 1]
        orders, errors = np.array([self._of_last(weights) for weights in contrasts]).T
        if not (orders > claim.floor).all():
            return np.inf
        quantile = scipy.special.stdtrit(GROUPS - 1, confidence)
        return float(max(1.0, np.max(quantile * errors / (orders - claim.floor)) ** 2))

    def _of_last(self, weights: list[float]) -> tuple[float, float]:
        """Return a weighted sum of log2 of the last differences, with its standard error."""
        D = self.differences[:, -len(weights) :]
        mean = D.mean(axis=0)
        se = (D / mean @ weights).std(ddof=1) / np.sqrt(GROUPS) / np.log(2.0)
        return float(np.log2(np.abs(mean)) @ weights), float(se)

    def p_wrong(self, order: float) -> float:
        """Return the p-value of the hypothesis that the mean tends to the exact one with an order."""
        D, m = self.differences, self.differences.shape[1] - 1
        tails = D * 2.0 ** (-order * (m - np.arange(m + 1))) / (2.0**order - 1.0)
        return max(exceeds(self.remainder(order), tail) for tail in tails.T)


class ChainTests(NamedTuple):
    """What all looks together say of a claim on one observable.

    Attributes
    ----------
    verified, slow, wrong : float
        p-values of the hypotheses that the claim fails, that the order is as claimed, and that the limit is right;
        each for all looks together.
    growth : float
        By which factor the number of chains must grow until the claim is verified, if the figures stay; infinite
        if they speak against it.
    """

    verified: float
    slow: float
    wrong: float
    growth: float

    @property
    def refuted(self) -> float:
        """p-value of the hypothesis that the claim holds: two tests can reject it."""
        return min(1.0, 2.0 * min(self.slow, self.wrong))


def samples(record: ChainRecord, levels: Array, observable: int, exact: float) -> list[BiasSample]:
    """Return the sample of one observable at each look.

    Parameters
    ----------
    record : ChainRecord
    levels : ndarray of int
        Levels that can be used, the finest among them.
    observable : int
    exact : float
        Its mean under the exact invariant law.

    Returns
    -------
    list of BiasSample
    """
    found = []
    for look, time in enumerate(record.time):
        means = record.levels[look][:, levels, observable]
        coarse = record.wide[look][:, observable] if levels[0] == 0 else means[:, 0]
        rounding = 64.0 * EPS * np.sqrt(time / record.h[-1]) * np.abs(means).max()
        found.append(BiasSample(record.h[levels], means, coarse, exact, float(rounding)))
    return found


def chain_tests(found: list[BiasSample], claim: Order, planned: float, evidence: Evidence) -> ChainTests:
    """Return what all looks say of a claimed order, each p-value being shared among the planned looks.

    Parameters
    ----------
    found : list of BiasSample
    claim : Order
    planned : float
        Number of looks that were planned.
    evidence : Evidence
        For the confidence of intervals and the level of a test.

    Returns
    -------
    ChainTests
    """
    last, confidence = found[-1], evidence.settings.confidence
    steady = last.is_settled(confidence) and not last.may_reach(claim)
    falls = [sample.p_falls(claim) for sample in found]
    slow = [sample.p_slow(claim) if steady else 1.0 for sample in found]
    wrong = [sample.p_wrong(claim.least) for sample in found]
    verified, too_slow, off = (min(1.0, planned * min(looks)) for looks in (falls, slow, wrong))
    growth = last.growth_to_keep(claim, confidence)
    needed = max(growth, sample_growth(falls[-1], evidence.level / planned, GROUPS))
    return ChainTests(verified if growth == 1.0 else 1.0, too_slow, off, needed)


def exceeds(a: Array, b: Array) -> float:
    """Return the p-value of the hypothesis |E a| <= |E b|; see `outweighs`.

    Parameters
    ----------
    a, b : ndarray, shape (K,)
        Group means.

    Returns
    -------
    float
    """
    return float(outweighs(a, b))
