"""Tests on one stationary mean from replicated chains: the order of its bias in h, and whether its limit is exact.

All tests use group means, which are independent and nearly normal, in one comparison of absolute values of
expectations. No logarithm of a noisy number is tested, so no effect has to be resolved first.

With b_l the bias at level l of m + 2, D_l = b_l - b_{l+1}, and order p claimed, p_0 = p - margin,

    order > p_0           |D_m| < 2^(-m p_0) |D_0|
    order < p_0           |D_m| > 2^(-m p_0) |D_0|
    limit wrong           |e| > 2^(-p (m-l)) |D_l|/(2^p - 1)   for every l,     e = b_{m+1} - D_m/(2^p - 1)
    limit confirmed       |e| < |b|/4,                                          b = b_0 - e

If the bias is c h^p, its part at the finest level is Richardson's tail D_m/(2^p - 1): e is the remaining error of the
mean, and b the bias at the coarsest level that the differences explain. The tail is allowed an error of
100 %, so a limit that is wrong by less than the tail is not refuted; one wrong by more than b/4 is never verified.
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

# Largest remaining error of a mean, relative to the bias at the coarsest level, for a confirmed limit.
# Chosen.
CONFIRMED = 0.25


@dataclass(frozen=True)
class BiasSample:
    """The group means of one observable at one look, on the usable levels.

    Attributes
    ----------
    h : ndarray, shape (L,)
    levels : ndarray, shape (K, L)
        Of the paired chains.
    coarse : ndarray, shape (K,)
        At the coarsest of these levels, from the largest available number of chains.
    exact : float
    rounding : float
        Bound of the rounding error of a mean.
    """

    h: Array
    levels: Array
    coarse: Array
    exact: float
    rounding: float

    @property
    def differences(self) -> Array:
        """D_l, shape (K, L - 1); exactly 0 if it does not exceed rounding."""
        D = self.levels[:, :-1] - self.levels[:, 1:]
        return np.asarray(np.where(np.abs(D).max(axis=0) <= self.rounding, 0.0, D))

    @property
    def errors(self) -> Array:
        """The bias at each level, shape (K, L): that of the coarsest level minus the paired differences."""
        gained = np.cumsum(np.insert(self.differences, 0, 0.0, axis=1), axis=1)
        return np.asarray((self.coarse - self.exact)[:, None] - gained)

    @property
    def signals(self) -> Array:
        """Mean differences in units of their standard errors, shape (L - 1,); 0 if the difference is 0."""
        return np.array([float(t_values(D)) for D in self.differences.T])

    @property
    def resolved(self) -> bool:
        """Whether all differences are significantly different from 0."""
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
        """Return Fieller's interval of the ratio D_m/D_0, as orders; valid for any noise of the differences."""
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
        """Return whether two resolved differences have opposite signs, as for a leading coefficient near 0."""
        found = self.signals
        return bool((found >= RESOLVED).any() and (found <= -RESOLVED).any())

    def p_falls(self, claim: Order) -> float:
        """Return the p-value of the hypothesis that the claimed order is not reached or the limit is not exact."""
        D, m = self.differences, self.differences.shape[1] - 1
        faster = exceeds(2.0 ** (-m * claim.floor) * D[:, 0], D[:, -1])
        remainder = self.remainder(claim.least)
        return max(faster, exceeds(CONFIRMED * (self.errors[:, 0] - remainder), remainder))

    def remainder(self, order: float) -> Array:
        """Return the finest error minus Richardson's tail for an order, shape (K,)."""
        return np.asarray(self.errors[:, -1] - self.differences[:, -1] / (2.0**order - 1.0))

    def p_slow(self, claim: Order) -> float:
        """Return the p-value of the hypothesis that the differences fall with the claimed order."""
        D, m = self.differences, self.differences.shape[1] - 1
        return exceeds(D[:, -1], 2.0 ** (-m * claim.floor) * D[:, 0])

    def is_settled(self, confidence: float) -> bool:
        """Return whether low local orders are not due to steps that are too coarse.

        There are at least three differences, all significant and of the same sign, and no local order increases with
        refinement by more than `RISING`, at the given confidence. Steps on which the order still rises, or on which
        the bias passes through 0, are no evidence against an order.
        """
        signs = np.sign(self.signals)
        if len(signs) < 3 or not self.resolved or np.any(signs != signs[0]):
            return False
        rise, se = self._of_last([-1.0, 2.0, -1.0])
        return bool(rise - scipy.special.stdtrit(GROUPS - 1, 0.5 + 0.5 * confidence) * se <= RISING)

    def may_reach(self, claim: Order) -> bool:
        """Return whether the local order, extrapolated by its last increase, may reach the claimed one.

        It may unless its one-sided 95 per cent interval is below, because few chains do not distinguish a rise from
        none. Needs at least three differences, as `is_settled` does.
        """
        ahead, se = self._of_last([-1.0, 3.0, -2.0])
        return bool(ahead + scipy.special.stdtrit(GROUPS - 1, 0.95) * se >= claim.floor)

    def growth_to_keep(self, claim: Order, confidence: float) -> float:
        """Return the factor by which the chains must grow to show the claimed order at the finest step sizes.

        An error a h + b h^2 has a mean order near 2 as long as b h is much larger than a; its local orders fall with
        each halving of h. So the tests are on the order of the two finest differences and, with three or more, the
        next one if it changes by the same amount: the lower ends of their one-sided intervals must be at least claim
        - margin.

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
        """Return the p-value of the hypothesis that the mean tends to the exact one with the given order."""
        D, m = self.differences, self.differences.shape[1] - 1
        tails = D * 2.0 ** (-order * (m - np.arange(m + 1))) / (2.0**order - 1.0)
        return max(exceeds(self.remainder(order), tail) for tail in tails.T)


class ChainTests(NamedTuple):
    """Tests of a claim on one observable over all looks.

    Attributes
    ----------
    verified, slow, wrong : float
        p-values of the hypotheses that the claim fails, that the order is as claimed, and that the limit is right;
        each for all looks together.
    growth : float
        Factor by which the number of chains must grow until the claim is verified, if the estimates stay; infinite
        if they contradict it.
    """

    verified: float
    slow: float
    wrong: float
    growth: float

    @property
    def refuted(self) -> float:
        """p-value of the hypothesis that the claim holds, which either of two tests can reject."""
        return min(1.0, 2.0 * min(self.slow, self.wrong))


def samples(record: ChainRecord, levels: Array, observable: int, exact: float) -> list[BiasSample]:
    """Return the sample of one observable at each look.

    Parameters
    ----------
    record : ChainRecord
    levels : ndarray of int
        Usable levels, including the finest.
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
    """Test a claimed order by all looks, with each p-value multiplied by the number of planned looks.

    Parameters
    ----------
    found : list of BiasSample
    claim : Order
    planned : float
        Number of looks that were planned.
    evidence : Evidence
        Provides the confidence of intervals and the level of a test.

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
