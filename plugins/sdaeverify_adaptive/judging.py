"""From a sample to findings on claims about tolerances, by the tests of all other measures."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from sdaeverify import Array, Moment, Settings
from sdaeverify.measuring import (
    FEWEST,
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
    group_sums,
    jackknife,
    order_tests,
    with_sample,
)
from sdaeverify.numerics import Tail, log_norms, slope_weights
from sdaeverify_solvers import Asked

from .limits import Limit, limit
from .sample import Sample

RATE, STEPS, LAW = "tolerance", "tolerance-steps", "tolerance-law"
EPS = float(np.finfo(float).eps)
LARGEST = 20


@dataclass(frozen=True)
class Question:
    """A sample with its derived quantities that all claims use.

    Attributes
    ----------
    sample : Sample
    with_limit : bool
        Whether the limit is tested; False only in a test of this option.
    """

    sample: Sample
    with_limit: bool = True

    @property
    def evidence(self) -> Evidence:
        """The sample as evidence: claims, paths and level of confidence."""
        sample = self.sample
        counted = Tally(sums={"paths": np.array([sample.budget.paths])})
        settings = Settings(paths=max(sample.budget.paths, 40), seed=sample.budget.seed)
        return Evidence(sample.solver, sample.problem, sample.view, settings, counted, Tally())

    @property
    def counts(self) -> Array:
        """Number of paths of each group, shape (G,)."""
        return group_sums(np.ones(self.sample.budget.paths))

    @property
    def tolerances(self) -> Array:
        """Tolerances with enough steps, largest first."""
        return np.asarray(self.sample.budget.tolerances)[self.sample.usable]


def ask(question: Question) -> Iterator[Asked]:
    """Yield the tests of each claim of a solver."""
    sample = question.sample
    for name, rows in parts(sample).items():
        for measure in (RATE, STEPS):
            covered = coverage(question.evidence, measure, name)
            if covered.claim is not None and not sample.solver.own_noise:
                yield _of_rate(question, measure, covered, rows)
    for truth in sample.problem.truths:
        if isinstance(truth, Moment):
            covered = coverage(question.evidence, LAW, truth.observable)
            if covered.claim is not None:
                yield _of_law(question, covered, truth)


def parts(sample: Sample) -> dict[str, slice]:
    """Return the rows of each named component of the state that the truth knows."""
    known = sample.problem.pathwise
    assert known is not None
    sizes = {
        name: len(np.atleast_2d(part)) for name, part in known.parts(sample.problem.horizon, known.start(1)).items()
    }
    ends = np.cumsum(list(sizes.values()))
    return {name: slice(int(end) - size, int(end)) for (name, size), end in zip(sizes.items(), ends, strict=True)}


def _of_rate(question: Question, measure: str, covered: Coverage, rows: slice) -> Asked:
    """Test an order in the tolerance, or in the mean number of steps."""
    sample, evidence, use = question.sample, question.evidence, question.sample.usable
    claim = covered.claim
    assert claim is not None
    nothing = Estimate(np.nan, np.nan)
    if len(use) < FEWEST:
        few = f"a rate needs {FEWEST} tolerances with at least 16 steps, got {len(use)}: use smaller tolerances"
        return Asked(measure, covered, PathTests.none(few), nothing, np.nan, evidence)
    if not isinstance(claim.value, Order):
        return Asked(measure, covered, PathTests.none("only an order can be tested"), nothing, np.nan, evidence)
    errors = sample.errors[use, rows]
    squares = (errors**2).sum(axis=1)
    order = rate(question, squares, measure)
    bias = rate_bias(question, squares, measure)
    tests = order_tests(claim, order, evidence, bias)
    limits = limits_of(question, errors, claim.value) if measure == RATE and question.with_limit else []
    tests = with_sample(with_limits(tests, limits), sample.budget.paths, heavy=is_heavy(squares[-1]))
    size = float(np.sqrt((sample.truth[rows] ** 2).sum(axis=0).mean()))
    seen = max((each.resolution for each in limits), default=np.nan) / size if size else np.nan
    return Asked(measure, covered, tests, order, seen, evidence)


def rate(question: Question, squares: Array, measure: str) -> Estimate:
    """Return the slope of log2 (E e^2)^(1/2) against log2 of the tolerance, or of 1/(mean number of tries).

    Parameters
    ----------
    question : Question
    squares : ndarray, shape (K, P)
        Squared errors at the usable tolerances.
    measure : str
    """
    tries = question.sample.tries[question.sample.usable]

    def slope(means: Array) -> float:
        sizes = np.log2(question.tolerances) if measure == RATE else -np.log2(means[1])
        return float(slope_weights(sizes) @ log_norms(means[0], 2.0))

    sums = group_sums(np.stack([squares, tries.astype(float)]))
    return jackknife(sums, question.counts, slope)


def rate_bias(question: Question, squares: Array, measure: str) -> float:
    """Return the bound sum |w_k| log2(1 + v/E e_k^2)/2 on the slope's bias, v the variance of the truth's error.

    Parameters
    ----------
    question : Question
        Sample with the truth and its error.
    squares : ndarray, shape (K, P)
        Squared errors at the usable tolerances.
    measure : str
        Measure that selects the slope.
    """
    sample = question.sample
    tries = sample.tries[sample.usable].mean(axis=-1)
    weights = slope_weights(np.log2(question.tolerances) if measure == RATE else -np.log2(tries))
    means = np.maximum(squares.mean(axis=-1), np.finfo(float).tiny)
    return float(np.abs(weights) @ (0.5 * np.log2(1.0 + sample.grid_error**2 / means)))


def limits_of(question: Question, errors: Array, claimed: Order) -> list[Limit]:
    """Return the test of the limit of each component.

    Parameters
    ----------
    question : Question
    errors : ndarray, shape (K, n, P)
        Errors at the usable tolerances.
    claimed : Order
        Claimed rate in the tolerance.
    """
    sample, tolerances = question.sample, question.tolerances
    ratios = (tolerances[-1] / tolerances[:-1]) ** claimed.floor
    # Rounding error of n additions of numbers of a given size.
    rounding = EPS * float(sample.tries.max()) * float(np.abs(sample.truth).max())
    confidence = question.evidence.settings.confidence
    rows = np.moveaxis(errors, 1, 0)
    bias = rounding + sample.grid_bias
    return [limit(group_sums(row), question.counts, ratios, bias, confidence) for row in rows]


def with_limits(tests: PathTests, limits: Sequence[Limit]) -> PathTests:
    """Add the tests of limits to those of a rate: the least p-value, times their number, refutes.

    Parameters
    ----------
    tests : PathTests
        Tests of the rate alone.
    limits : sequence of Limit
    """
    if not limits:
        return tests
    worst = min(limits, key=lambda each: each.p)
    p = min(1.0, len(limits) * worst.p)
    refuted = min(1.0, 2.0 * min(tests.refuted, p))
    told = "the mean error tends to {limit:.2g} +- {se:.1g}"
    numbers = {"limit": worst.extrapolated.value, "se": worst.extrapolated.se}
    reason = tests.reason.then(Reason(told, Kind.WRONG_LIMIT, numbers)) if p <= 1e-3 else tests.reason
    return tests._replace(refuted=refuted, suspected=min(tests.suspected, p), limit=p, reason=reason)


def is_heavy(squares: Array) -> bool:
    """Return whether a mean of squared errors, shape (P,), is dominated by few paths."""
    largest = np.sort(squares)[::-1][: max(LARGEST, int(np.sqrt(len(squares))))]
    return Tail.of(float(squares.sum()), float((squares**2).sum()), largest, len(squares)).heavy


def _of_law(question: Question, covered: Coverage, truth: Moment) -> Asked:
    """Test the bias of an observable at the finest tolerance.

    The mean uses the truth as control variate, y - b (z - E z) with the b of least variance: about 1 for a solver
    that follows the path, and near 0 for one that draws its own noise.
    """
    sample, evidence = question.sample, question.evidence
    T, claim = sample.problem.horizon, covered.claim
    assert claim is not None
    rows = parts(sample)
    y, z = (
        sample.problem.observe(truth.observable, T, {name: state[rows[name]] for name in rows})
        for state in (sample.runs.ends[-1], sample.truth)
    )
    if y is None or z is None or not isinstance(claim.value, Bound):
        none = PathTests.none("the observable is unknown" if y is None or z is None else "only a bound can be tested")
        return Asked(LAW, covered, none, Estimate(np.nan, np.nan), np.nan, evidence)
    mean = truth.value(T)

    def bias_of(means: Array) -> float:
        y_, z_, yz, zz = means
        slope = (yz - y_ * z_) / (zz - z_**2)
        return float(y_ - slope * (z_ - mean) - mean)

    estimate = jackknife(group_sums(np.stack([y, z, y * z, z * z])), question.counts, bias_of)
    tests = bound_tests(estimate, claim.value.most, evidence).unless_vacuous(claim.value.most, float(z.std()))
    heavy = is_heavy((y - y.mean()) ** 2)
    return Asked(LAW, covered, with_sample(tests, sample.budget.paths, heavy=heavy), estimate, np.nan, evidence)


def bound_tests(bias: Estimate, most: float, evidence: Evidence) -> PathTests:
    """Return the tests of a bias against a two-sided bound.

    Parameters
    ----------
    bias : Estimate
    most : float
        Claimed largest absolute value.
    evidence : Evidence
    """
    low, high = bias.interval(evidence.settings.confidence)
    text = "bias {bias:.2g}, at least {low:.2g} and at most {high:.2g}; claimed within {most:.2g}"
    reason = Reason(text, numbers={"bias": bias.value, "low": low, "high": high, "most": most})
    inside = max(bias.p_above(-most), bias.p_below(most))
    outside = min(1.0, 2.0 * min(bias.p_above(most), bias.p_below(-most)))
    return PathTests(inside, outside, reason, bias.growth_to_decide(np.copysign(most, bias.value), evidence.level))
