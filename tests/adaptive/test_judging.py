"""From errors to verdicts: rates, wrong limits and biases, on errors whose law is known."""

import numpy as np
import pytest

from adaptive.solving import GBM, findings, path, problem, sample, solver, verdicts
from sdaeverify import UsageError
from sdaeverify.measuring import group_sums
from sdaeverify_adaptive import TICKS
from sdaeverify_adaptive.judging import Question, is_heavy, rate
from sdaeverify_adaptive.limits import limit
from sdaeverify_adaptive.sample import Budget, Runs, Sample, truth

TOLERANCES = (2.0**-4, 2.0**-6, 2.0**-8, 2.0**-10)
COUNTS = group_sums(np.ones(400))
RATIOS = (TOLERANCES[-1] / np.array(TOLERANCES[:-1])) ** 0.3


def made(errors, steps=64, paths=400):
    """Return a sample of heun-pi on ou with given errors at the four tolerances."""
    seen = problem("ou")
    counts = np.full((len(TOLERANCES), paths), steps) * (1 + np.arange(len(TOLERANCES)))[:, None]
    exact = np.random.default_rng(0).standard_normal((1, paths))
    runs = Runs(exact + errors[:, None], counts, 0 * counts, counts)
    return Sample(solver("heun-pi"), seen, seen, Budget(paths, TOLERANCES, 1), runs, exact)


def falling(order, paths=400, mean=0.0, seed=1):
    """Return errors of a size tau^order that share their normals, and a mean beside."""
    xi = np.random.default_rng(seed).standard_normal(paths)
    return np.array(TOLERANCES)[:, None] ** order * xi + mean


def test_a_rate_is_that_of_the_errors():
    """Errors of the size tau^0.7 have the slope 0.7, to rounding, and the steps theirs."""
    question = Question(made(falling(0.7)))
    squares = question.sample.errors[:, 0] ** 2

    assert rate(question, squares, "tolerance").value == pytest.approx(0.7)
    assert rate(question, squares, "tolerance-steps").value > 0.7


@pytest.mark.parametrize(
    ("order", "mean", "verdict"), [(0.5, 0, "verified"), (0.1, 0, "refuted"), (1, 0.02, "refuted")]
)
def test_a_claim_is_held_against_rate_and_limit(order, mean, verdict):
    """A claim of 1/2 holds for errors of that rate; it falls with one of 0.1, and with a mean that stays."""
    assert verdicts(made(falling(order, mean=mean)))["tolerance", "x"] == verdict


def test_a_mean_that_falls_faster_than_claimed_is_no_wrong_limit():
    """A mean error of the size tau, far above its standard error, speaks for the solver."""
    errors = np.array(TOLERANCES)[:, None] * (1.0 + 0.01 * np.random.default_rng(2).standard_normal(400))

    assert limit(group_sums(errors), COUNTS, RATIOS, 0.0, 0.99).p > 0.5


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_limit_is_extrapolated(sign):
    """Of a mean L + C tau^(q - margin), the test finds L, of either sign."""
    xi = np.random.default_rng(3).standard_normal(400)
    errors = sign * (0.3 + np.array(TOLERANCES)[:, None] ** 0.3 * (0.5 + 0.01 * xi))
    found = limit(group_sums(errors), COUNTS, RATIOS, 0.0, 0.99)

    assert found.extrapolated.value == pytest.approx(sign * 0.3, abs=0.01)
    assert found.p < 1e-6


def test_a_small_mean_at_one_tolerance_is_no_alarm():
    """Where the mean changes its sign on the way, a coarser tolerance speaks for the solver."""
    xi = 1e-3 * np.random.default_rng(4).standard_normal(400)
    errors = np.array([0.3, 0.1, 0.0, 0.02])[:, None] + xi

    assert limit(group_sums(errors), COUNTS, RATIOS, 0.0, 0.99).p > 0.5


def test_a_bias_of_the_truth_is_no_wrong_limit():
    """A mean that is no larger than what the truth may be off by refutes nothing."""
    errors = 1e-3 + 1e-5 * np.random.default_rng(5).standard_normal((4, 400))
    sure, unsure = (limit(group_sums(errors), COUNTS, RATIOS, bias, 0.99).p for bias in (0.0, 2e-3))

    assert sure < 1e-6
    assert unsure > 0.5


def test_false_alarms_of_the_limit_are_rarer_than_promised():
    """On 300 samples of errors without a mean, the p-value is below 0.05 hardly more often than its level says."""
    rng = np.random.default_rng(6)
    scale = np.array(TOLERANCES)[:, None] ** 0.5
    hits = sum(
        limit(group_sums(scale * rng.standard_normal((4, 400))), COUNTS, RATIOS, 0.0, 0.99).p < 0.05
        for _ in range(300)
    )

    # Binomial with n = 300 and p = 0.05 exceeds 34 once in 10^5 times.
    assert hits <= 34


def test_few_steps_say_nothing_of_a_rate():
    """Tolerances with fewer than 16 steps are left out, and two of them are no slope."""
    found = findings(made(falling(0.5), steps=6))["tolerance", "x"]

    assert found.verdict.value == "inconclusive"
    assert "at least 16 steps" in str(found.reason)


def test_heavy_tails_are_seen():
    """A square that carries a tenth of the mean makes it heavy."""
    squares = np.ones(400)

    assert not is_heavy(squares)
    assert is_heavy(np.where(np.arange(400) == 0, 44.0, squares))


def test_a_law_is_judged_with_the_truth_as_a_control():
    """A solver whose end is the truth's with a small error has a bias that is known far below its own deviation."""
    found = findings(made(falling(0.5)))["tolerance-law", "x"]

    assert found.high - found.low < 0.1


@pytest.mark.parametrize(
    "given", [{"paths": 30}, {"paths": 410}, {"tolerances": (0.1, 0.2, 0.3)}, {"tolerances": (0.1,)}]
)
def test_a_budget_that_cannot_be_judged_is_refused(given):
    """Paths come in whole groups, and tolerances fall."""
    with pytest.raises(UsageError):
        Budget(**given)


def test_a_truth_on_the_path_is_the_formula():
    """Geometric Brownian motion is exp((a - b^2/2) T + b W(T)) of this very path."""
    mine = path()
    expected = np.exp(0.1 - 0.32 + 0.8 * mine.at(TICKS).W)

    assert np.allclose(truth(problem(GBM), mine), expected, rtol=1e-12)


def test_a_small_sample_has_both_ends():
    """What a solver took is counted for each path: it rejects steps, and tries no fewer than it makes."""
    found = sample("heun-pi", GBM, 40, tolerances=TOLERANCES[:3])

    assert np.all(found.runs.rejected[-1].sum() > 0)
    assert np.all(found.tries >= found.runs.steps)
