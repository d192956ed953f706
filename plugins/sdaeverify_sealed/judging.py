r"""From samples to tests: orders in law and bounds of a bias, from independent runs at each step size.

With e_l = E phi(X_l) - E phi(X) at step sizes h_0 > ... > h_L, and q = p - margin for a claimed order p,

    verified    |e_L| < (h_L/h_0)^q |e_0|,   |r| < |e_0 - r|/4,   r = (e_L - s e_{L-1})/(1 - s),   s = (h_L/h_{L-1})^p
    slow        |e_L| > (h_L/h_J)^q |e_J|   for every J < L

No logarithm of a noisy number is tested: each line is a comparison of absolute values of expectations (`outweighs`),
valid whatever the noise is. The error of the mean is known at each step size by itself, because the mean of the
solution is; a limit that is wrong is an error that does not fall. It is said of one that is slow for an order of 1/4.
What is left of an error c h^p is r: an error that falls on its way to another limit is not verified. Nor is one whose
local order, changed once more as it changed last, is surely below the claim; one whose local order may reach the
claim in this way is not slow. Errors that change their sign refute nothing: steps are too coarse for an order.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Problem, Settings
from sdaeverify.measuring import (
    Bound,
    Coverage,
    Estimate,
    Evidence,
    Kind,
    Order,
    PathTests,
    Reason,
    Tally,
    coverage,
    jackknife,
    order_tests,
    with_sample,
)
from sdaeverify.numerics import GROUPS, outweighs, sample_growth, slope_weights
from sdaeverify.probing import why_not_resolved
from sdaeverify.studying import RESOLVED
from sdaeverify_solvers import Asked

from .contract import Sealed
from .sample import Sample

# Half of the least order that a scheme can have: of an error that falls more slowly it is said that it does not fall.
LIMIT = 0.25
# Confidence at which a local order that rises with refinement may still reach what is claimed: as of chains.
REACHES = 0.95
# As of chains: a limit is confirmed if it is known up to this part of the error at the coarsest step size.
CONFIRMED = 0.25
UNBIASED = "unbiased"
UNSEEN = "the error at the coarsest step size is below the sampling noise: take coarser steps, or claim `unbiased`"
ONES = np.ones(GROUPS)


class Question(NamedTuple):
    """A sample, and whose it is.

    Attributes
    ----------
    solver : Sealed
    problem : Problem
        As registered.
    view : Problem
        As the solver sees it.
    sample : Sample
    confidence : float
    """

    solver: Sealed
    problem: Problem
    view: Problem
    sample: Sample
    confidence: float

    @property
    def evidence(self) -> Evidence:
        """The sample as evidence: claims, number of paths and level of confidence."""
        counted = Tally(sums={"paths": np.array([self.sample.paths])})
        settings = Settings(paths=self.sample.paths, confidence=self.confidence)
        return Evidence(self.solver, self.problem, self.view, settings, counted, Tally())


def ask(question: Question) -> Iterator[Asked]:
    """Yield the tests of each claim that the sample covers."""
    evidence = question.evidence
    for name in question.sample.plan.names:
        covered = coverage(evidence, question.sample.plan.measure, name)
        if covered.claim is not None:
            yield _about(question, covered, evidence)


def _about(question: Question, covered: Coverage, evidence: Evidence) -> Asked:
    sample, claim = question.sample, covered.claim
    assert claim is not None
    name, looks = covered.quantity, len(sample.looks)
    column = sample.plan.names.index(name)
    all_errors = [sample.errors(name, look) for look in range(1, looks + 1)]
    value = claim.value
    if isinstance(value, Order):
        tests, estimate = _of_order(question, all_errors, (covered, value), evidence)
    elif isinstance(value, Bound) and value.text == UNBIASED:
        tests, estimate = _of_bound(question, all_errors, (covered, value), evidence)
    else:
        none = PathTests.none("not tested: an order or a bound of a bias is asked for")
        return Asked(sample.plan.measure, covered, none, Estimate(np.nan, np.nan), np.nan, evidence)
    tests = with_sample(tests, sample.paths, heavy=bool(sample.looks[-1].heavy[column]))
    low, high = mean_of(all_errors[-1][:, -1]).interval(question.confidence, sample.known[name].bias)
    size = _size(sample, name)
    seen = max(abs(low), abs(high)) / size if size > 0.0 else np.nan
    return Asked(sample.plan.measure, covered, tests, estimate, seen, evidence)


def _size(sample: Sample, name: str) -> float:
    """Return the root mean square of an observable at the finest step size; NaN if the runs do not determine it."""
    look, column = sample.looks[-1], sample.plan.names.index(name)
    variance = look.within[-1, :, column].mean() * sample.sizes[len(sample.looks) - 1]
    return float(np.sqrt(variance + look.means[-1, :, column].mean() ** 2))


def mean_of(values: Array) -> Estimate:
    """Return the mean of a number that each of the G groups has, shape (G,), with its standard error."""
    return Estimate(float(values.mean()), float(values.std(ddof=1) / np.sqrt(GROUPS)))


def _of_order(
    question: Question, errors: Sequence[Array], covered: tuple[Coverage, Order], evidence: Evidence
) -> tuple[PathTests, Estimate]:
    """Return the tests of a claimed order over all looks, and the slope of the errors of the last one."""
    (asked, claimed), sample = covered, question.sample
    h, bias = sample.plan.h, sample.known[asked.quantity].bias
    claim = asked.claim
    assert claim is not None
    spent = len(sample.sizes)
    falls = min(1.0, spent * min(p_falls(e, h, claimed, bias) for e in errors))
    slow = min(1.0, spent * min(p_slower(e, h, claimed.floor, bias) for e in errors))
    reaches = may_reach(errors[-1], h, claimed)
    slope = slope_of(errors[-1], h)
    growth = sample_growth(p_falls(errors[-1], h, claimed, bias), evidence.level / spent, GROUPS)
    reason = _figures(errors[-1], h).then(order_tests(claim, slope, evidence, of="in law").reason)
    if not reaches and p_slower(errors[-1], h, LIMIT, bias) <= 1.0 - question.confidence:
        reason = reason.then(Reason("the error does not fall", Kind.WRONG_LIMIT))
    tests = PathTests(falls if reaches else 1.0, 1.0 if reaches else slow, reason, growth, slow)
    why = why_not_resolved(question.view, float(h[-1])) or why_no_order(errors[-1])
    if why != UNSEEN and not first_is_seen(errors[-1]):
        tests = tests._replace(reason=reason.then(UNSEEN))
    return (tests.held(why) if why else tests), slope


def first_is_seen(errors: Array) -> bool:
    """Return whether the error at the coarsest step size exceeds the sampling noise; errors have shape (G, L + 1)."""
    first = mean_of(errors[:, 0])
    return abs(first.value) >= RESOLVED * first.se


def slope_of(errors: Array, h: Array) -> Estimate:
    """Return the slope of log2 |E e_l| over log2 h_l by the jackknife; NaN or wide where errors are noise.

    Parameters
    ----------
    errors : ndarray, shape (G, L + 1)
    h : ndarray, shape (L + 1,)
    """
    weights = slope_weights(np.log2(h))
    with np.errstate(all="ignore"):
        return jackknife(errors, ONES, lambda means: float(weights @ np.log2(np.abs(means))))


def p_falls(errors: Array, h: Array, claimed: Order, bias: float = 0.0) -> float:
    """Return the p-value of the hypothesis that errors do not fall with an order, or not towards 0.

    Parameters
    ----------
    errors : ndarray, shape (G, L + 1)
        Of the means of each group of paths.
    h : ndarray, shape (L + 1,)
    claimed : Order
    bias : float
        By how much the mean that they are compared with may be off.
    """
    shrunk = float((h[-1] / h[-2]) ** claimed.least)
    rest = (errors[:, -1] - shrunk * errors[:, -2]) / (1.0 - shrunk)
    confirmed = _exceeds(CONFIRMED * (errors[:, 0] - rest), rest, (1.0 + CONFIRMED) * bias)
    ratio = float((h[-1] / h[0]) ** claimed.floor)
    return max(_exceeds(ratio * errors[:, 0], errors[:, -1], (1.0 + ratio) * bias), confirmed)


def p_slower(errors: Array, h: Array, order: float, bias: float = 0.0) -> float:
    """Return the p-value of the hypothesis that errors fall with an order from one coarser step size at least.

    Parameters
    ----------
    errors, h, bias
        As of `p_falls`.
    order : float
    """
    ratios = (h[-1] / h[:-1]) ** order
    return max(
        _exceeds(errors[:, -1], ratio * errors[:, level], (1.0 + ratio) * bias) for level, ratio in enumerate(ratios)
    )


def _exceeds(a: Array, b: Array, bias: float) -> float:
    """Return the p-value of the hypothesis |E a| <= |E b| + bias."""
    others = (b, np.full_like(b, bias)) if bias else (b,)
    return float(outweighs(a, *others))


def may_reach(errors: Array, h: Array, claimed: Order) -> bool:
    """Return whether the local order, if it changes once more as it did last, may be the claimed one.

    Errors on steps that are too coarse have local orders that rise with refinement, which is no evidence against a
    claim. An order that is below the sampling noise counts as possible.

    Parameters
    ----------
    errors, h
        As of `p_falls`.
    claimed : Order
    """
    x = np.log2(h[-3:])

    def ahead(means: Array) -> float:
        y = np.log2(np.abs(means[-3:]))
        before, last = np.diff(y) / np.diff(x)
        return float(2.0 * last - before)

    with np.errstate(all="ignore"):
        return not jackknife(errors, ONES, ahead).upper_bound(REACHES) < claimed.floor


def why_no_order(errors: Array) -> str:
    """Return why errors determine neither an order nor a limit, or an empty string.

    Errors a h - b h^2 that change their sign between step sizes do not fall at those near the root. If the coarsest
    error is below the sampling noise, so is perhaps its sign, and finer steps with smaller errors would not decide.

    Parameters
    ----------
    errors : ndarray, shape (G, L + 1)
    """
    means = errors.mean(axis=0)
    if not means.min() < 0.0 < means.max():
        return ""
    return (
        "the error changes its sign between step sizes: finer steps would decide" if first_is_seen(errors) else UNSEEN
    )


def _figures(errors: Array, h: Array) -> Reason:
    each = [mean_of(column) for column in errors.T]
    told = ", ".join(f"{one.value:.2g}" for one in each)
    text = "errors {errors} (standard error up to {se:.1g}) at h = {h}"
    sizes = ", ".join(f"{size:.3g}" for size in h)
    return Reason(text, numbers={"errors": told, "se": max(one.se for one in each), "h": sizes})


def _of_bound(
    question: Question, errors: Sequence[Array], covered: tuple[Coverage, Bound], evidence: Evidence
) -> tuple[PathTests, Estimate]:
    """Return the tests of a bias that is claimed to be within a bound at every step size, and the largest bias."""
    (asked, value), sample = covered, question.sample
    spent, bias = len(sample.sizes), sample.known[asked.quantity].bias
    tested = [_of_levels(e, value.most, bias) for e in errors]
    within, beyond = (min(1.0, spent * min(p)) for p in zip(*tested, strict=True))
    each = [mean_of(column) for column in errors[-1].T]
    at = int(np.argmax([abs(one.value) for one in each]))
    low, high = each[at].interval(question.confidence, bias)
    text = "largest bias {bias:.2g}, between {low:.2g} and {high:.2g}, at h = {h:.3g}; claimed within {most:g}"
    numbers = {"bias": each[at].value, "low": low, "high": high, "h": sample.plan.h[at], "most": value.most}
    growth = sample_growth(min(tested[-1]), evidence.level / spent, GROUPS)
    # A bias at a step size may be that of an order or that of another law: the kind of the reason is left plain.
    tests = PathTests(within, beyond, Reason(text, numbers=numbers), growth)
    spread = _spread(sample, asked.quantity)
    return tests.unless_vacuous(value.most, spread), each[at]


def _of_levels(errors: Array, most: float, bias: float) -> tuple[float, float]:
    """Return the p-values of the hypotheses that a bias is beyond a bound at a step size, and that it is within."""
    granted = np.full_like(errors, most)
    off = (np.full_like(errors, bias),) if bias else ()
    within, beyond = outweighs(granted, errors, *off), outweighs(errors, granted, *off)
    return float(within.max()), min(1.0, len(beyond) * float(beyond.min()))


def _spread(sample: Sample, name: str) -> float:
    """Return the standard deviation of an observable at the finest step size; NaN if the runs do not determine it."""
    look = sample.looks[-1]
    of_mean = look.within[-1, :, sample.plan.names.index(name)].mean()
    return float(np.sqrt(of_mean * sample.sizes[len(sample.looks) - 1]))


def is_decided(asked: Sequence[Asked], level: float) -> bool:
    """Return whether each of some claims is decided at a level, so that no further look is needed."""
    return all(min(one.tests.verified, one.tests.refuted) <= level for one in asked)
