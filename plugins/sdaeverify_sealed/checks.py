"""Checks of a sealed solver in addition to its claims: seeds, standard errors, and Brownian motions.

Verdicts rest on the spread of means between runs with different seeds. So runs that are equal although their seeds
differ leave the cell without a standard error, and no claim is judged then.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array
from sdaeverify.measuring import Coverage, Estimate, PathTests, Reason
from sdaeverify.numerics import GROUPS
from sdaeverify_solvers import Asked

from .judging import Question
from .sample import Look, Plan, Runner, digest_of

SEEDS, REPEATS, SPREAD, MOTIONS = "own seeds", "same seed", "standard errors", "Brownian motion"
# A variance within this factor of what it should be is told from one that is not: a standard error within its root.
FACTOR = 2.0
# The mean of the squared standard errors has to be known better than the variance between seeds by this factor.
STEADY = 0.5
# A moment of W(T)/sqrt(T) counts as right if its interval lies within this distance of it.
CLOSE = 0.1


class Answer(NamedTuple):
    """What a check found that needs no statistics.

    Attributes
    ----------
    check : str
    failed : str
        The fault in a sentence; empty if there is none.
    told : str
        A remark that is not a failure; empty if there is none.
    """

    check: str
    failed: str = ""
    told: str = ""


def check_seeds(digests: list[str], seeds: list[int]) -> Answer:
    """Check that runs with different seeds are different.

    Parameters
    ----------
    digests : list of str
        Of all runs of a look, step size by step size.
    seeds : list of int
        Of the same runs.
    """
    first: dict[str, int] = {}
    for digest, seed in zip(digests, seeds, strict=True):
        if first.setdefault(digest, seed) != seed:
            why = "their means have no standard error, and nothing is judged"
            return Answer(SEEDS, f"seeds {first[digest]} and {seed} give the same numbers: {why}")
    return Answer(SEEDS)


def check_repeats(runner: Runner, plan: Plan, paths: int, digest: str) -> Answer:
    """Tell whether the same seed gives the same numbers. It is a fact of the solver, and no claim.

    Parameters
    ----------
    runner : Runner
    plan : Plan
    paths : int
        Of the first run of the first look.
    digest : str
        Of what it returned.
    """
    again = runner.once(plan, plan.h[0], paths, runner.seeds(plan, 0, 0)[0])
    told = (
        "the same seed gives two results: a run cannot be made again, and its verdicts hold for new numbers each time"
    )
    return Answer(REPEATS, told="" if digest_of(again) == digest else told)


def statistical(question: Question) -> Iterator[Asked]:
    """Yield the checks that are tests: standard errors, and the moments of W(T)."""
    if question.solver.independent:
        yield _of_spread(question)
    if question.sample.looks[0].motions.shape[-1]:
        yield _of_motions(question)


def _of_spread(question: Question) -> Asked:
    """Return whether means of runs spread as their standard errors say.

    The variance of G means over the mean of their squared standard errors has the law of chi^2_{G-1}/(G - 1); step
    sizes and looks are independent, so that their sums add. Left out are observables with tails so heavy that the
    mean of the squared standard errors is uncertain itself.
    """
    looks, covered = question.sample.looks, Coverage(f"{question.sample.plan.measure} means", None)
    ratios = np.array([look.means.var(axis=1, ddof=1) / _within(look) for look in looks])
    degrees = (GROUPS - 1) * ratios.shape[0] * ratios.shape[1]
    usable = np.isfinite(ratios).all(axis=(0, 1)) & (_uncertain(looks) < STEADY * (2.0 / degrees) ** 0.5)
    if not usable.any():
        none = PathTests.none("no observable has a standard error that is known well enough")
        return Asked(SPREAD, covered, none, Estimate(np.nan, np.nan), np.nan, question.evidence)
    ratio = ratios.mean(axis=(0, 1))[usable]
    names = np.array(question.sample.plan.names)[usable]
    at = int(np.argmax(np.abs(np.log(ratio))))
    estimate = Estimate(float(ratio[at]), float(ratio[at] * (2.0 / degrees) ** 0.5))
    text = "the variance of means of {name} between seeds is {ratio:.3g} times what a run tells of it"
    reason = Reason(text, numbers={"name": names[at], "ratio": ratio[at]})
    return Asked(SPREAD, covered, _spread_tests(ratio, degrees, reason), estimate, np.nan, question.evidence)


def _within(look: Look) -> Array:
    # An observable without any spread says nothing of one.
    return np.asarray(np.where(look.within > 0.0, look.within, np.nan).mean(axis=1))


def _uncertain(looks: Sequence[Look]) -> Array:
    """Return the relative standard error of the mean of all squared standard errors, shape (K,)."""
    within = np.concatenate([look.within for look in looks])
    relative = within / within.mean(axis=1, keepdims=True)
    return np.asarray(relative.std(axis=(0, 1)) / np.sqrt(relative.shape[0] * relative.shape[1]))


def _spread_tests(ratio: Array, degrees: int, reason: Reason) -> PathTests:
    """Return the tests of the ratios of all observables: each has to be 1, and is right if it is within a factor."""
    low, high = scipy.special.chdtr(degrees, degrees * ratio), scipy.special.chdtrc(degrees, degrees * ratio)
    too_large = scipy.special.chdtr(degrees, degrees * ratio / FACTOR)
    too_small = scipy.special.chdtrc(degrees, degrees * ratio * FACTOR)
    refuted = min(1.0, 2.0 * len(ratio) * float(np.minimum(low, high).min()))
    return PathTests(float(np.maximum(too_large, too_small).max()), refuted, reason)


def _of_motions(question: Question) -> Asked:
    """Return whether the motions at T that a solver reports have means 0, covariance T I and kurtosis 3."""
    looks, sizes = question.sample.looks, question.sample.sizes
    weights = np.array(sizes[: len(looks)]) / sum(sizes[: len(looks)])
    moments = np.einsum("j,jgm->gm", weights, np.stack([look.motions.mean(axis=0) for look in looks]))
    each = [Estimate(float(m.mean()), float(m.std(ddof=1) / np.sqrt(GROUPS))) for m in moments.T]
    refuted = min(1.0, len(each) * min(2.0 * min(one.p_above(0.0), one.p_below(0.0)) for one in each))
    verified = max(max(one.p_above(-CLOSE), one.p_below(CLOSE)) for one in each)
    worst = max(each, key=lambda one: abs(one.value) / one.se if one.se > 0.0 else np.inf)
    text = "of the moments of W(T)/sqrt(T) up to the fourth, one is off by {off:.2g} +- {se:.1g}"
    reason = Reason(text, numbers={"off": worst.value, "se": worst.se})
    covered = Coverage("W(T)", None)
    return Asked(MOTIONS, covered, PathTests(verified, refuted, reason), worst, np.nan, question.evidence)
