"""Order estimates with confidence intervals, by the delete-a-group jackknife on sums over groups of paths.

Every statistic here is a smooth function of mean values on the same paths at all levels, so that one jackknife over
groups of paths accounts for the correlation between levels.
"""

from collections.abc import Callable
from math import isfinite
from typing import NamedTuple

import numpy as np
import scipy

from ..arrays import Array

GROUPS = 20
ROOT = np.sqrt(GROUPS)
EPS = float(np.finfo(float).eps)
# Steps that are too coarse for the problem show as local orders that increase by more than this per level.
RISING = 0.05
# Effective share of the paths in a mean below which its tails are heavy.
HEAVY = 0.2


class Estimate(NamedTuple):
    """An estimated value with its standard error.

    Attributes
    ----------
    value, se : float
    """

    value: float
    se: float

    def interval(self, confidence: float, bias: float = 0.0) -> tuple[float, float]:
        """Return the two-sided interval value +- t_{G-1} se, widened by a bound of the bias on both sides."""
        half = _quantile(0.5 + 0.5 * confidence) * self.se + bias
        return self.value - half, self.value + half

    def upper_bound(self, confidence: float, bias: float = 0.0) -> float:
        """Return the upper end of the one-sided interval: larger values are rejected at level 1 - confidence."""
        return self.value + _quantile(confidence) * self.se + bias

    def p_above(self, bound: float, bias: float = 0.0) -> float:
        """Return the p-value of the hypothesis that the true value is at most `bound`; 1 if it is not finite."""
        return _p_value(self.value - bias - bound, self.se)

    def p_below(self, bound: float, bias: float = 0.0) -> float:
        """Return the p-value of the hypothesis that the true value is at least `bound`; 1 if it is not finite."""
        return _p_value(bound - bias - self.value, self.se)

    def growth_to_decide(self, bound: float, level: float, bias: float = 0.0) -> float:
        """Return the factor by which the sample must grow to distinguish the value from `bound`; infinite if never.

        The distance is taken to stay the same, and the standard error to fall like 1/sqrt(paths).

        Parameters
        ----------
        bound : float
            Value to be distinguished from.
        level : float
            Level of the one-sided test.
        bias : float
            Subtracted from the distance, in the unit of the value: a systematic error that more paths do not reduce.
        """
        distance = abs(self.value - bound) - bias
        if not (distance > 0.0 and isfinite(self.se)):
            return float("inf")
        needed = _quantile(1.0 - level) * self.se / distance
        return max(1.0, needed**2)

    def growth_to_see(self, size: float, confidence: float, bias: float = 0.0) -> float:
        """Return the factor by which the sample must grow to detect a deviation of a given size; infinite if never.

        It is detected if a test of level 1 - confidence rejects with a probability of `confidence`.

        Parameters
        ----------
        size : float
            Deviation, in the unit of the value.
        confidence : float
            Between 0 and 1.
        bias : float
            Systematic error, which may hide this much of the deviation.
        """
        if not (size > bias and isfinite(self.se)):
            return float("inf")
        return max(1.0, (2.0 * _quantile(confidence) * self.se / (size - bias)) ** 2)


def _quantile(probability: float) -> float:
    return float(scipy.special.stdtrit(GROUPS - 1, probability))


def _p_value(distance: float, se: float) -> float:
    if not isfinite(distance):
        return 1.0
    if not se > 0.0:
        return 0.0 if distance > 0.0 and se == 0.0 else 1.0
    return float(scipy.special.stdtr(GROUPS - 1, -distance / se))


def correct_for_skewness(p: float, skewness: float, count: float) -> float:
    """Return the p-value of a one-sided test of a mean, corrected for the skewness of the terms.

    For the mean of n independent variables over its own standard error, with the skewness g,

        P(T <= -z) = Phi(-z) exp(g z^3 / (3 sqrt(n))) (1 + O((1 + z)/sqrt(n)))

    (self-normalised large deviations: Shao 1999, Wang 2005). A sample without large values has a mean that is too
    small, and a standard error that is too small as well. The right side decreases until z = sqrt(n)/g; z is not
    taken beyond.

    Parameters
    ----------
    p : float
        p-value without the correction, for the hypothesis that the mean is at least its observed value.
    skewness : float
        g, or -g for the hypothesis that the mean is at most its observed value. A negative one changes nothing.
    count : float
        n.

    Returns
    -------
    float
        At least `p`.
    """
    if not (skewness > 0.0 and 0.0 <= p < 0.5):
        return p
    z = min(float(-scipy.special.ndtri(p)), float(np.sqrt(count)) / skewness)
    log = float(scipy.special.log_ndtr(-z)) + skewness * z**3 / (3.0 * float(np.sqrt(count)))
    return float(max(p, min(1.0, np.exp(log))))


def group_sums(values: Array) -> Array:
    """Sum values over groups of paths; path i is in group i mod G.

    Parameters
    ----------
    values : ndarray, shape (..., P)

    Returns
    -------
    ndarray, shape (G, ...)
    """
    whole = values.shape[-1] // GROUPS * GROUPS
    rounds = values[..., :whole].reshape(*values.shape[:-1], -1, GROUPS)
    sums = rounds.sum(axis=-2)
    rest = values[..., whole:]
    sums[..., : rest.shape[-1]] += rest
    return sums if sums.ndim == 1 else np.moveaxis(sums, -1, 0)


def jackknife(sums: Array, counts: Array, statistic: Callable[[Array], float]) -> Estimate:
    """Estimate a function of means by the jackknife, bias-corrected, with its standard error.

    With the value b_n on all paths and b_(g) without group g, the pseudo-values are
    G b_n - (G - 1) b_(g). The estimate is their mean, its standard error their standard deviation over sqrt(G).

    Parameters
    ----------
    sums : ndarray, shape (G, ...)
        Sums over each group.
    counts : ndarray, shape (G,)
        Number of paths of each group.
    statistic : callable, ndarray of shape (...) -> float
        Function of the means.

    Returns
    -------
    Estimate
    """
    return _estimates(np.atleast_2d(pseudo_values(sums, counts, statistic)))[0]


def jackknives(sums: Array, counts: Array, statistics: Callable[[Array], Array]) -> tuple[Estimate, ...]:
    """Estimate several functions of means by the jackknife, vectorised over the left-out groups; see `jackknife`.

    Parameters
    ----------
    sums : ndarray, shape (G, ...)
        Sums over each group.
    counts : ndarray, shape (G,)
        Paths of each group.
    statistics : callable, ndarray of shape (n, ...) -> ndarray of shape (n, k) or (n,)
        One or k functions of n sets of means.
    """
    return estimates(statistics(leave_out(sums, counts)))


def estimates(values: Array) -> tuple[Estimate, ...]:
    """Estimate one or k statistics from their values, shape (1 + G,) or (1 + G, k), on the output of `leave_out`."""
    found = np.ascontiguousarray(np.atleast_2d(values.T))
    return _estimates(GROUPS * found[:, :1] - (GROUPS - 1) * found[:, 1:])


def _estimates(pseudo: Array) -> tuple[Estimate, ...]:
    # As `mean` and `std` do, without the time that these take to check their arguments.
    mean = np.add.reduce(pseudo, axis=1) / GROUPS
    centred = pseudo - mean[:, np.newaxis]
    square = np.add.reduce(centred * centred, axis=1) / (GROUPS - 1)
    return tuple(map(Estimate, mean.tolist(), (np.sqrt(square) / ROOT).tolist()))


def pseudo_values(sums: Array, counts: Array, statistic: Callable[[Array], float | Array]) -> Array:
    """Return the jackknife pseudo-values of one or many statistics, shape (G, ...); see `jackknife`.

    Parameters
    ----------
    sums : ndarray, shape (G, ...)
        Sum of each group of paths.
    counts : ndarray, shape (G,)
        Number of paths of each group.
    statistic : callable, means -> float or ndarray
        Function of the means over paths.
    """
    found = np.array([statistic(each) for each in leave_out(sums, counts)])
    return np.asarray(GROUPS * found[0] - (GROUPS - 1) * found[1:])


def leave_out(sums: Array, counts: Array) -> Array:
    """Return the means over all paths, and over all paths without each group, shape (1 + G, ...).

    The result is in C order, so that a sum over some columns has the same bits as for a single row.
    """
    if len(counts) != GROUPS:
        raise ValueError(f"expected sums over {GROUPS} groups of paths, got {len(counts)}")
    total, n = np.add.reduce(sums), np.add.reduce(counts)
    means = np.empty((1 + GROUPS, *total.shape))
    means[0] = total / n
    means[1:] = (total - sums) / (n - counts).reshape(-1, *(1,) * total.ndim)
    return means


def slope_weights(x: Array) -> Array:
    """Return the weights w of the least-squares slope sum_l w_l y_l over abscissae x."""
    centred = x - np.add.reduce(x) / len(x)
    return np.asarray(centred / (centred @ centred))


def corrected_slope_weights(x: Array, power: float = 1.0) -> Array:
    """Return the weights of p in the fit y = a + p x + c 2^(power x): the asymptotic order, x = log2 h."""
    design = np.stack([np.ones_like(x), x, 2.0 ** (power * (x - x.max()))], axis=1)
    return np.array(np.linalg.pinv(design)[1])


def lower_term_weights(x: Array, power: float = 1.0) -> Array:
    """Return the weights that estimate the share s of an error term of half an order less, from y - p x, x = log2 h.

    With u = 2^(x - min x), an error b h^p (1 - s + s u^(-1/2)) has y = p x + a + (s/ln 2) (u^(-1/2) - 1) for small s.
    The fit has the next term of the expansion as well: y = p x + a' + (s/ln 2) u^(-1/2) + c u^power.

    Parameters
    ----------
    x : ndarray, shape (L,)
        log2 of at least three step sizes.
    power : float, optional
        Difference between the order of the next term and the leading order.

    Returns
    -------
    ndarray, shape (L,)
        w with s = sum_l w_l (y_l - p x_l).
    """
    u = 2.0 ** (x - x.min())
    return np.asarray(np.log(2.0) * np.linalg.pinv(np.stack([u**-0.5, np.ones_like(u), u**power], axis=1))[0])


def order_of(h: Array, sums: Array, counts: Array, p: float = 1.0) -> Estimate:
    """Return the order in h of (E e^p)^(1/p): the least-squares slope of log2, by the jackknife.

    Parameters
    ----------
    h : ndarray, shape (L,)
        Step sizes.
    sums : ndarray, shape (G, L)
        Sums of e^p over each group.
    counts : ndarray, shape (G,)
        Number of paths of each group.
    p : float, optional

    Returns
    -------
    Estimate
    """
    return log_functional(sums, counts, slope_weights(np.log2(h)), p)


def log_functional(sums: Array, counts: Array, weights: Array, p: float = 1.0) -> Estimate:
    """Estimate sum_l w_l log2 (E e_l^p)^(1/p) by the jackknife.

    Parameters
    ----------
    sums : ndarray, shape (G, L)
        Sums of e_l^p over each group.
    counts : ndarray, shape (G,)
        Number of paths of each group.
    weights : ndarray, shape (L,)
        w, one per level.
    p : float, optional
        Exponent of the norm.
    """
    return jackknives(sums, counts, lambda means: weighted_sum(weights, log_norms(means, p)))[0]


def weighted_sum(weights: Array, values: Array) -> Array:
    """Return sum_l w_l y_l over the last axis of y.

    Parameters
    ----------
    weights : ndarray, shape (L,)
    values : ndarray, shape (..., L)
    """
    # einsum instead of a BLAS product: its bits do not depend on the number of threads.
    return np.asarray(np.einsum("l,...l->...", weights, values))


def log_norms(means: Array, p: float | Array) -> Array:
    """Return log2 (E e^p)^(1/p), with p common to all columns or one per column."""
    return np.asarray(np.log2(means) / p)


class Tail(NamedTuple):
    """Concentration of a mean on few paths.

    Attributes
    ----------
    effective : float
        (sum e)^2 / (M sum e^2), effective share of the paths; 1 for equal errors.
    share : float
        Share of the largest error in the sum.
    hill : float
        Hill's index of the tail from the sqrt(M) largest values.
    """

    effective: float
    share: float
    hill: float

    @classmethod
    def of(cls, total: float, total_of_squares: float, largest: Array, paths: int) -> "Tail":
        """Return the concentration of a sum of errors.

        Parameters
        ----------
        total, total_of_squares : float
            Sums of e and e^2 over all paths.
        largest : ndarray, shape (k,)
            The k largest errors, descending.
        paths : int
        """
        top = largest[largest > 0.0]
        excess = np.add.reduce(np.log(top[:-1] / top[-1])) / (len(top) - 1) if len(top) > 1 else 0.0
        effective = total**2 / (paths * total_of_squares) if total_of_squares > 0.0 else 1.0
        share = largest[0] / total if total > 0.0 else 0.0
        return cls(float(effective), float(share), float(1.0 / excess) if excess > 0.0 else float("inf"))

    @property
    def heavy(self) -> bool:
        """Whether the tail is so heavy that intervals of the mean cannot be trusted."""
        return self.effective < HEAVY or self.share > 0.05 or self.hill < 1.8


def clopper_pearson(hits: int, trials: int, confidence: float) -> tuple[float, float]:
    """Return the Clopper-Pearson interval of a rate: the p for which the count is in neither tail of Binomial(n, p).

    With tails of alpha/2 on both sides it covers the true rate with at least the nominal probability, for every n and
    p: low and high are the quantiles of Beta(k, n - k + 1) at alpha/2 and of Beta(k + 1, n - k) at 1 - alpha/2.

    Parameters
    ----------
    hits, trials : int
        k of n.
    confidence : float
        1 - alpha.
    """
    outside = 0.5 * (1.0 - confidence)
    low = float(scipy.special.betaincinv(hits, trials - hits + 1, outside)) if hits else 0.0
    high = float(scipy.special.betaincinv(hits + 1, trials - hits, 1.0 - outside)) if hits < trials else 1.0
    return low, high


def chernoff(mean: Array, bound: float, count: Array | float) -> Array:
    """Return Hoeffding's bound of the probability that a mean of shares is this far from its expectation.

    exp(-n KL(m | q)), KL(m | q) = m ln(m/q) + (1 - m) ln((1 - m)/(1 - q)), for shares between 0 and 1 of any law
    (Hoeffding 1963, Theorem 1, (2.1)).

    Parameters
    ----------
    mean : ndarray, shape (...)
        m.
    bound : float
        q, the expectation.
    count : ndarray, shape (...), or float
        n.
    """
    return np.asarray(
        np.exp(-count * (scipy.special.rel_entr(mean, bound) + scipy.special.rel_entr(1.0 - mean, 1.0 - bound)))
    )


def chernoff_interval(mean: float, count: float, confidence: float) -> tuple[float, float]:
    """Return the interval of expectations that `chernoff` does not reject for an observed mean of shares.

    Parameters
    ----------
    mean, count : float
        m of n independent shares.
    confidence : float
        1 - alpha; alpha/2 on each side.
    """
    outside = 0.5 * (1.0 - confidence)

    def beyond(q: float) -> float:
        return float(chernoff(np.asarray(mean), q, count)) - outside

    low = float(scipy.optimize.brentq(beyond, 0.0, mean)) if mean > 0.0 else 0.0
    high = float(scipy.optimize.brentq(beyond, mean, 1.0)) if mean < 1.0 else 1.0
    return low, high
