"""Verdicts on stationary means: from records of chains that are prescribed, from chains that are run, and without."""

import re
from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from scipy.stats import binom

from facade import CHAINS, GROUPS, OPERATOR, BiasSample, ChainRecord, Invariant, exceeds
from facade import double_well as shipped_double_well
from sdaeverify import Claim, InvariantMean, Settings
from sdaeverify.measures.invariant.chain_findings import is_decided
from sdaeverify.measuring import Evidence, Tally, Verdict, packed, unpacked
from sdaeverify.simulate.chains import chains_of
from stationary_cells import (
    VARIANCE,
    Euler,
    Heun,
    Shaken,
    charted_ou,
    double_well,
    euler_variance,
    heun_variance,
    ou,
    rotation,
)

H = 0.25 / 2.0 ** np.arange(4)
NAMES = ("x", "x^2", "x^4")
PROBLEM = ou()
EXACT = np.array([truth.value for truth in PROBLEM.truths])
LEVEL = 0.005


class Claimless(Euler):
    """Euler-Maruyama without claims."""

    promises = ()


class Exactness(Euler):
    """Euler-Maruyama that claims something in words."""

    promises = (Claim(measure="invariant", value="round-off", source="test"),)


def record(*biases, spread=1e-4, looks=1, seed=1, **fields):
    """Return a record of chains whose biases are given as functions of h, the last one for all further observables.

    Group means have a common error `spread`, and differences between levels a hundredth of it for each h.
    """
    rng = np.random.default_rng(seed)
    biases = [*biases, *([biases[-1]] * (len(NAMES) - len(biases)))]
    bias = np.stack([np.broadcast_to(function(H), H.shape) for function in biases], axis=-1)
    common = rng.normal(size=(looks, GROUPS, 1, 3)) * spread
    own = rng.normal(size=(looks, GROUPS, 4, 3)) * 0.01 * spread * (H / H[0])[:, None]
    known = {
        "h": H,
        "levels": EXACT + bias + common + own,
        "wide": EXACT + bias[0] + rng.normal(size=(looks, GROUPS, 3)) * 0.25 * spread,
        "time": 10.0 * 2.0 ** np.arange(looks),
        "planned": 6.0,
        "paired": 1024.0,
        "chains": 8192.0,
        "burn_in": 10.0,
        "stationary": 1.0,
        "contraction": 1e-6,
        "diverged": np.nan,
        "lost": np.zeros(4),
        "failed": np.zeros(4),
        "truncated": np.zeros(4),
    }
    return ChainRecord(**(known | fields))


def findings(chains, scheme=None, level=LEVEL):
    """Return the findings on a record of chains by observable."""
    evidence = Evidence(scheme or Euler(), PROBLEM, PROBLEM, Settings(), packed(CHAINS, chains), Tally(), level=level)
    return {finding.quantity: finding for finding in Invariant().judge(evidence).findings}


def verdicts(chains, scheme=None, level=LEVEL):
    """Return the verdicts on a record of chains by observable."""
    return {name: finding.verdict for name, finding in findings(chains, scheme, level).items()}


def probed(scheme, problem, seed=20170601):
    """Return what a probe found, and the findings."""
    settings = Settings(seed=seed, tests_reserved=1)
    tally = Invariant().probe(scheme, problem, settings)
    judgement = Invariant().judge(Evidence(scheme, problem, problem, settings, tally, Tally(), level=settings.level))
    return tally, {finding.quantity: finding for finding in judgement.findings}


def linear(h):
    return 0.1 * h


def test_the_claimed_order_is_verified():
    """A bias 0.1 h verifies order 1, with its order and leading coefficient."""
    found = findings(record(linear))["x^2"]

    assert found.verdict is Verdict.VERIFIED
    assert found.estimate == pytest.approx(1.0, abs=0.01)
    assert found.low < 1.0 < found.high
    assert found.details["leading_coefficient"] == pytest.approx(0.1, rel=0.01)
    assert found.p_verified <= LEVEL < found.p_refuted


def squared(h):
    return 0.2 * h**2


FIRST, LAST = np.eye(4)[[0, 3]]
RIGHT, WRONG, OPEN = Verdict.VERIFIED, Verdict.REFUTED, Verdict.INCONCLUSIVE
# A record, who claims something of it, the verdict on each observable, and what is said of x^2.
CASES = {
    "h^.5 of a claim of 1": (record(lambda h: 0.1 * h**0.5), Euler(), WRONG, ""),
    "h^.7 of a claim of 1": (record(lambda h: 0.1 * h**0.7), Euler(), WRONG, ""),
    "h of a claim of 2": (record(linear), Euler(order=2.0), WRONG, ""),
    "h^2 of a claim of 1": (record(squared), Euler(), RIGHT, ""),
    "h^2 of a claim of 2": (record(squared), Euler(order=2.0), RIGHT, ""),
    "h^2 of a claim of 3": (record(squared), Euler(order=3.0), WRONG, ""),
    "means known no better": (
        record(linear, spread=0.05),
        Euler(),
        OPEN,
        "about 4100 chains up to t = 10 would decide (--paths 33000)",
    ),
    "a claim in words": (record(linear), Exactness(), OPEN, ""),
    "no claim": (record(linear), Claimless(), Verdict.OUT_OF_SCOPE, ""),
    "a coarse level blew up": (record(linear, spread=1e-5, lost=FIRST), Euler(), RIGHT, "diverged at h = 0.25"),
    "the finest level blew up": (record(linear, lost=LAST), Euler(), Verdict.DIVERGED, ""),
    "one level is left": (
        record(linear, truncated=9.0 - 9.0 * LAST),
        Euler(),
        OPEN,
        "truncated steps at 3 step sizes",
    ),
    "means that still move": (record(linear, stationary=0.0), Euler(), OPEN, ""),
    "means that still move, of a claim of 2": (record(linear, stationary=0.0), Euler(order=2.0), OPEN, ""),
    "chains that stay apart": (record(linear, contraction=0.9), Euler(), RIGHT, "do not approach each other"),
}


@pytest.mark.parametrize(("chains", "scheme", "verdict", "reason"), CASES.values(), ids=CASES)
def test_records_of_a_known_bias_have_their_verdict(chains, scheme, verdict, reason):
    """The same of all observables, as they have the same bias."""
    found = findings(chains, scheme)

    assert {finding.verdict for finding in found.values()} == {verdict}
    assert reason in str(found["x^2"].reason)


def test_a_wrong_limit_is_refuted_although_differences_fall():
    """A constant error leaves differences of order 1 and is seen by the mean alone; nothing else is verified."""
    found = findings(record(linear, lambda h: 0.1 * h + 0.01, linear))

    assert found["x^2"].verdict is Verdict.REFUTED
    assert str(found["x^2"].reason).startswith("wrong limit: off by 0.01")
    assert found["x^4"].verdict is Verdict.INCONCLUSIVE
    assert str(found["x^4"].reason).startswith("not confirmed: wrong limit in x^2")
    assert found["x^4"].p_verified == 1.0


def test_an_order_that_still_rises_is_not_refuted():
    """Local orders 0.15, 0.53 of a bias h - 1.5 h^2 belong to steps that are too coarse, not to a low order."""
    found = findings(record(lambda h: 0.1 * (h - 1.5 * h**2)))["x^2"]

    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.estimate < 0.6


def test_an_order_that_rises_to_the_claim_is_not_refuted_where_the_rise_is_not_sure():
    """SRA1 on a linear system that is far from normal: local orders 0.5, 1.6, and 2 at last, known roughly."""
    bias, noise = np.array([-0.239, -0.122, -0.0383, -0.0105]), np.array([0.13, 0.035, 0.0075, 0.002])
    rng = np.random.default_rng(2)
    levels = EXACT + bias[:, None] + noise[:, None] * rng.normal(size=(1, GROUPS, 4, 3))
    wide = EXACT + bias[0] + 0.5 * rng.normal(size=(1, GROUPS, 3))

    found = findings(record(linear, levels=levels, wide=wide), Euler(order=2.0))

    assert {finding.verdict for finding in found.values()} == {Verdict.INCONCLUSIVE}


def test_a_bias_that_changes_its_sign_is_uninformative():
    """An observable whose differences have two signs is left out while others tell the order."""
    found = findings(record(linear, lambda h: 0.1 * (h - 4.0 * h**2), linear))

    assert found["x^2"].verdict is Verdict.NOT_APPLICABLE
    assert "changes sign" in str(found["x^2"].reason)
    assert found["x"].verdict is Verdict.VERIFIED


def test_a_bias_that_is_not_seen_is_uninformative_while_others_are():
    """An observable without bias is left out with a message that names the others."""
    found = findings(record(lambda h: 0.0 * h, linear))

    assert found["x"].verdict is Verdict.NOT_APPLICABLE
    assert "not informative: bias below sampling noise" in str(found["x"].reason)
    assert "x^2, x^4" in str(found["x"].reason)
    assert np.isnan(found["x"].p_verified)


def test_an_unseen_bias_is_refuted_where_its_limit_is_wrong():
    """An observable without bias in h still refutes a scheme that has another mean."""
    assert findings(record(lambda h: 0.0 * h + 0.01, linear))["x"].verdict is Verdict.REFUTED


def test_without_any_bias_nothing_is_decided():
    """Where all differences are noise, all is inconclusive, and no number of chains is said to show an order.

    The number would grow with each run: bias that is not there is resolved by no number.
    """
    found = findings(record(lambda h: 0.0 * h))

    assert {finding.verdict for finding in found.values()} == {Verdict.INCONCLUSIVE}
    told = [str(finding.reason) for finding in found.values()]
    assert all("ias below sampling noise" in reason for reason in told)
    assert not any("chains up to t" in reason for reason in told)


def test_the_chains_that_would_resolve_a_bias_are_not_said_to_decide_its_order():
    """A bias of one to three standard errors."""
    reason = str(findings(record(linear, spread=3.0))["x^2"].reason)

    assert "bias below sampling noise" in reason
    assert "would resolve it (--paths " in reason


@pytest.mark.parametrize(("paths", "chains"), [(40, 1024), (8192, 1024), (65536, 8192), (10**9, 131072)])
def test_paths_set_the_number_of_chains(paths, chains):
    """An eighth of the paths, from 1024 on, up to what is held in memory together."""
    assert chains_of(paths) == (chains, 8 * chains)


class Bounded(Euler):
    """Euler-Maruyama that claims a bias of x^2 slightly above the one it has, 0.035 at h = 0.25."""

    promises = (Claim(measure="invariant", value="unbiased", bound=0.039, quantities=("x^2",), source="test"),)


@pytest.mark.long
def test_a_bound_that_few_chains_leave_open_is_decided_by_the_paths_it_asks_for():
    """The reason names --paths with its number, with which the same claim is decided."""
    open_, asked = probed_at(Bounded(), 8192)
    decided, _ = probed_at(Bounded(), asked)

    assert (open_.verdict, decided.verdict) == (Verdict.INCONCLUSIVE, Verdict.VERIFIED)
    assert 8192 < asked < 10**6


def probed_at(scheme, paths):
    """Return the finding on x^2 with a number of paths, and the number that its reason asks for; 0 for none."""
    settings = Settings(paths=paths, max_looks=1)
    tally = Invariant().probe(scheme, PROBLEM, settings)
    evidence = Evidence(scheme, PROBLEM, PROBLEM, settings, tally, Tally(), level=settings.level)
    (found,) = (found for found in Invariant().judge(evidence).findings if found.quantity == "x^2")
    told = re.search(r"--paths (\d+)", str(found.reason))
    return found, int(told[1]) if told else 0


@pytest.mark.long
def test_more_paths_have_chains_of_their_own():
    """Digits of 1024 and of 2048 chains differ, which no option did to them before."""
    short = replace(PROBLEM, relaxation_time=0.5)
    few, many = (
        unpacked(CHAINS, ChainRecord, Invariant().probe(Euler(), short, Settings(paths=paths, max_looks=1)))
        for paths in (8192, 16384)
    )
    assert (few.paired, many.paired) == (1024.0, 2048.0)
    assert not np.array_equal(few.levels, many.levels)


@pytest.mark.slow
@pytest.mark.parametrize("bias", [0.0, 1e-6, 1e-4])
def test_noise_decides_nothing(bias):
    """Of 300 records at the boundary of a claim, no more are decided falsely than the level allows at 1e-4."""
    samples = 300
    found = [verdicts(record(lambda h: bias * h**0.8, looks=2, seed=seed))["x^2"] for seed in range(samples)]

    for verdict in (Verdict.VERIFIED, Verdict.REFUTED):
        assert found.count(verdict) <= binom.ppf(1.0 - 1e-4, samples, LEVEL)


def test_levels_hold_the_bias_at_each_step_size():
    """Each level reports its bias, from the many coarse chains and the paired differences."""
    chains = record(linear)
    evidence = Evidence(Euler(), PROBLEM, PROBLEM, Settings(), packed(CHAINS, chains), Tally())
    rows = [row for row in Invariant().judge(evidence).levels if row.quantity == "x^2"]

    assert [row.h for row in rows] == list(H)
    assert all(row.level is None for row in rows)
    for row in rows:
        assert abs(row.estimate - linear(row.h)) < 4.0 * row.std_error < 1e-4


def test_looks_end_when_enough_is_decided():
    """A refutation ends the looks; an observable that is not seen does not while it may be resolved yet."""
    verified, hopeless = record(linear), record(lambda h: 0.0 * h, linear)
    not_yet = record(lambda h: 4e-6 * h, linear)

    assert is_decided(list(findings(verified).values()), verified)
    assert is_decided(list(findings(verified, Euler(order=2.0)).values()), verified)
    assert is_decided(list(findings(verified, Claimless()).values()), verified)
    assert findings(not_yet)["x"].verdict is findings(hopeless)["x"].verdict is Verdict.NOT_APPLICABLE
    assert not is_decided(list(findings(not_yet).values()), not_yet)
    assert is_decided(list(findings(hopeless).values()), hopeless)


@pytest.mark.sweep
@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (-1.0, 1.0), (0.0, 0.0), (0.02, -0.02)])
def test_comparisons_keep_their_level_at_equality(a, b):
    """Where |E a| = |E b|, at most 5 per cent of samples reject it at 5 per cent, within what 2000 of them allow."""
    rng, samples = np.random.default_rng(4), 2000
    noise = rng.multivariate_normal([0.0, 0.0], [[1.0, 0.6], [0.6, 2.0]], size=(samples, GROUPS))

    rejected = sum(exceeds(a + x[:, 0], b + x[:, 1]) <= 0.05 for x in noise)

    assert rejected <= binom.ppf(1.0 - 1e-4, samples, 0.05)


def test_comparisons_reject_what_is_larger():
    """A clear difference is seen, in one direction only, whatever the signs; not a number rejects nothing."""
    noise = np.random.default_rng(4).normal(size=(2, GROUPS)) * 0.01

    assert exceeds(-1.0 + noise[0], 0.5 + noise[1]) < 1e-20
    assert exceeds(0.5 + noise[0], -1.0 + noise[1]) == 1.0
    assert exceeds(np.full(GROUPS, np.nan), noise[0]) == 1.0
    assert exceeds(np.ones(GROUPS), np.zeros(GROUPS)) == 0.0


@pytest.mark.parametrize("signal", [2.0, 5.0, 50.0])
def test_order_intervals_cover_however_noisy(signal):
    """Fieller's 95 % intervals contain the order with differences of 2, 5 and 50 standard errors."""
    rng, samples, covered = np.random.default_rng(6), 1000, 0
    bias = signal / np.sqrt(GROUPS) * H / H[0]
    for _ in range(samples):
        levels = bias + 0.5 * rng.normal(size=(GROUPS, 4))
        low, high = BiasSample(H, levels, levels[:, 0], 0.0, 0.0).order_interval(0.95)
        covered += low <= 1.0 <= high

    assert covered >= binom.ppf(1e-4, samples, 0.95)


def test_the_operator_comes_first():
    """On a problem with a chart the stationary law is computed, and tells the known biases to rounding."""
    tally, found = probed(Euler(), charted_ou())
    errors = tally.sums[f"{OPERATOR} errors"][:, 1]

    np.testing.assert_allclose(errors, euler_variance(tally.sums[f"{OPERATOR} h"]) - VARIANCE, atol=1e-9)
    assert found["x^2"].verdict is Verdict.VERIFIED
    assert found["x^2"].estimate == pytest.approx(1.0, abs=0.02)
    assert found["x^2"].tier == 2
    assert np.isnan(found["x^2"].p_verified)


def test_chains_decide_what_the_operator_leaves_open():
    """Findings of the operator stand where they decide; those of the chains take the place of the others."""
    problem = charted_ou()
    tally = Invariant().probe(Euler(), problem, Settings())
    resolution = tally.sums[f"{OPERATOR} resolution"] + np.array([0.0, 1.0, 0.0])
    blurred = Tally(sums={**tally.sums, f"{OPERATOR} resolution": resolution})
    both = blurred.merge(packed(CHAINS, record(linear)))
    evidence = Evidence(Euler(), problem, problem, Settings(), both, Tally(), level=LEVEL)

    found = {finding.quantity: finding for finding in Invariant().judge(evidence).findings}
    alone = Invariant().judge(replace(evidence, tally=blurred)).findings

    assert {finding.quantity: finding.tier for finding in found.values()} == {"x": 2, "x^2": 3, "x^4": 2}
    assert found["x"].verdict is Verdict.NOT_APPLICABLE
    assert found["x^2"].verdict is found["x^4"].verdict is Verdict.VERIFIED
    assert [finding.verdict for finding in alone if finding.quantity == "x^2"] == [Verdict.INCONCLUSIVE]


def test_the_operator_tells_order_two_from_one():
    """Without sampling, Heun's scheme has order 2, Euler's does not, and a wrong variance has none."""
    assert probed(Heun(order=2.0), charted_ou())[1]["x^2"].verdict is Verdict.VERIFIED
    assert probed(Euler(order=2.0), charted_ou())[1]["x^2"].verdict is Verdict.REFUTED
    assert probed(Euler(excess=0.05), charted_ou())[1]["x^2"].verdict is Verdict.REFUTED


@pytest.mark.parametrize("excess", [1e-2, 1e-3, 1e-4])
def test_the_operator_sees_small_errors_that_stay(excess):
    """A wrong variance that hardly changes local orders is found by extrapolation to h = 0."""
    found = probed(Euler(excess=excess), charted_ou())[1]["x^2"]

    assert found.verdict is Verdict.REFUTED
    assert float(str(found.reason).split()[4]) == pytest.approx(excess * VARIANCE, rel=0.05)


def test_nothing_is_run_without_a_claim_or_a_relaxation_time():
    """Chains are run only where something is claimed and it is known how long to run."""
    assert not Invariant().probe(Claimless(), ou(), Settings()).sums
    assert not Invariant().probe(Euler(), ou(relaxation_time=np.inf), Settings()).sums
    assert {f.verdict for f in probed(Claimless(), ou())[1].values()} == {Verdict.OUT_OF_SCOPE}
    assert {f.verdict for f in probed(Euler(), ou(relaxation_time=np.inf))[1].values()} == {Verdict.INCONCLUSIVE}


def test_problems_without_invariant_means_are_refused():
    """The question needs a known mean under an invariant law."""
    assert Invariant().refuses(Euler(), ou()) == ""
    assert "invariant law" in Invariant().refuses(Euler(), replace(ou(), truths=()))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_euler_on_ou_by_chains(seed):
    """Order 1 is verified from chains; the known bias is within 4 standard errors, the order in its interval."""
    tally, found = probed(Euler(), ou(), seed)
    bias = found["x^2"].details["bias"] - (euler_variance(1 / 32) - VARIANCE)
    D = -np.diff(euler_variance(tally.sums[f"{CHAINS} h"]))

    assert found["x^2"].verdict is found["x^4"].verdict is Verdict.VERIFIED
    assert found["x"].verdict is Verdict.NOT_APPLICABLE
    assert abs(bias) < 4.0 * found["x^2"].details["bias_std_error"]
    assert found["x^2"].low - 0.01 < 0.5 * np.log2(D[0] / D[-1]) < found["x^2"].high + 0.01


@pytest.mark.slow
def test_heun_on_ou_by_chains():
    """A bias of 0.4 per cent is found to be of order 2, within its interval of the known differences."""
    tally, found = probed(Heun(order=2.0), ou())
    D = np.diff(heun_variance(tally.sums[f"{CHAINS} h"]))

    assert found["x^2"].low < 0.5 * np.log2(D[0] / D[-1]) < found["x^2"].high
    assert found["x^2"].low > 1.8
    assert found["x^2"].verdict in {Verdict.VERIFIED, Verdict.INCONCLUSIVE}


@pytest.mark.slow
def test_rotations_show_no_contraction():
    """Euler's scheme is exact on the circle without drift: no bias, no order, and chains that keep their distance."""
    _, found = probed(Euler(), rotation())

    assert {finding.verdict for finding in found.values()} == {Verdict.INCONCLUSIVE}
    assert all("do not approach each other" in str(finding.reason) for finding in found.values())


def test_known_means_are_those_of_the_observables():
    """The invariant means of the problems used here agree with quadratures of their densities."""
    x = np.linspace(-6.0, 6.0, 4001)
    for problem, density in [(ou(), np.exp(-(x**2) / (2.0 * VARIANCE))), (double_well(), np.exp(x**2 - 0.5 * x**4))]:
        for truth in problem.truths:
            assert isinstance(truth, InvariantMean)
            value = problem.observables[truth.observable](0.0, {"x": x[None]})
            assert truth.value == pytest.approx((value * density).sum() / density.sum(), abs=1e-9)


def test_a_cell_that_costs_far_more_than_others_says_what_it_would_take():
    """Shallow noise in two wells: chains forget their start in 104, and a step is a quarter of a horizon of .462."""
    problem = shipped_double_well(sigma=0.366, x_0=0.165, horizon=0.462)
    begin = process_time()

    _, found = probed(Shaken(), problem)

    assert process_time() - begin < 5.0
    for name in ("x^2", "x^4"):
        assert found[name].verdict is Verdict.INCONCLUSIVE
        reason = str(found[name].reason)
        # 10 relaxation times of burn-in and as many of a record, on four levels, in steps of 2 x .462/8.
        steps = float(reason.split("chains would take ")[1].split(maxsplit=1)[0])
        assert steps == pytest.approx(2 * 15 * 10 * problem.relaxation_time / 0.1155, rel=2e-3)
        assert f"relaxation time {problem.relaxation_time:.3g}" in reason
        assert "at most 40000 are allowed" in reason


def test_steps_that_would_be_too_many_after_a_divergence_are_told():
    """Chains that blew up at the smallest size that can be run: what the next one takes is said."""
    lost = record(linear, looks=1)._replace(h=H / 64.0, time=np.empty(0), lost=np.full(4, 3.0), diverged=H[0] / 64.0)
    reason = str(findings(lost)["x^2"].reason)
    assert "chains would take 153600 steps of h = 0.002" in reason
    assert "diverged at h = " in reason
