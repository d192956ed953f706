"""Each limit of a rule of verdicts, from either side: a rule that is turned or a limit that moves fails here."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from facade import (
    EulerMaruyama,
    StrongOrder,
    beside,
    claim_for,
    gbm,
    judge_strong,
    lies_below,
    resolve_order,
    sound_levels,
    too_coarse,
    unlike,
    up_to,
    why_vacuous,
)
from sdaeverify import Claim, Scheme, Settings
from sdaeverify.measuring import (
    Estimate,
    Evidence,
    Finding,
    Kind,
    Opinion,
    Order,
    PathTests,
    Reason,
    Tally,
    Verdict,
    decide,
    group_sums,
    guard,
    local_doubt,
    order_tests,
    with_sample,
)
from study.test_agreement import CLAIM, LAW, PATHS, PROBLEM, agreeing, left, result, verified

ONE = Claim(measure="any", value=1.0, source="test")
LOCAL = Opinion(Verdict.VERIFIED, Reason("strong order 1.00"), 1)
NOTHING = PathTests(1.0, 1.0, Reason("figures"))


def evidence(paths=4096, **settings):
    """Return evidence of a number of paths, and of nothing else."""
    tally = Tally(sums={"paths": group_sums(np.ones(paths))} if paths else {})
    return Evidence(EulerMaruyama(), gbm(), gbm(), Settings(paths=8192, **settings), tally, Tally())


class TestOrders:
    """Orders along paths."""

    @pytest.mark.parametrize(("se", "sure"), [(0.069, True), (0.071, False)])
    def test_an_interval_wider_than_the_margin_verifies_nothing(self, se, sure):
        """Half of the interval at 99 per cent is 2.861 standard errors, and the margin is 0.2."""
        found = order_tests(ONE, Estimate(2.0, se), evidence())
        assert (found.verified < 1e-6) is sure
        assert found.growth == pytest.approx(1.0 if sure else (2.8609 * se / 0.2) ** 2, abs=1e-3)

    def test_a_bias_as_large_as_the_margin_is_helped_by_no_paths(self):
        """Its interval is never narrower."""
        assert order_tests(ONE, Estimate(3.0, 0.01), evidence(), bias=0.2).growth == inf
        assert order_tests(ONE, Estimate(3.0, 0.01), evidence(), bias=0.19).growth < inf

    def test_a_claim_of_exactness_is_refuted_by_an_order(self):
        """An order exists only if there are errors beyond rounding."""
        found = order_tests(Claim(measure="any", value="round-off", source="test"), Estimate(9.0, 0.1), evidence())
        assert (found.verified, found.refuted) == (1.0, 0.0)

    @pytest.mark.parametrize(("slope", "p"), [(0.70, "low"), (0.88, "near"), (0.91, "like")])
    def test_an_order_between_claim_and_floor_is_judged_by_its_half(self, slope, p):
        """Below the floor it is unlike the claim, below its middle as long as the further fit is, too."""
        low, high = (unlike(ONE.value, Estimate(slope, 1e-4), Estimate(value, 1e-4)) for value in (0.85, 0.95))
        assert (low < 0.01, high < 0.01) == {"low": (True, True), "near": (True, False), "like": (False, False)}[p]

    @pytest.mark.parametrize(("share", "resolved"), [(0.099, True), (0.101, False)])
    def test_a_lower_term_of_a_tenth_of_the_error_leaves_an_order_open(self, share, resolved):
        """The share is the upper end of its interval."""
        found = resolve_order(NOTHING._replace(verified=1e-9), Order(1.0), Estimate(share, 1e-9), evidence())
        assert (found.verified == 1e-9) is resolved
        assert found.reason.has(Kind.FINER) is not resolved


class TestSamples:
    """Sizes of samples."""

    def test_an_interval_needs_a_hundred_paths(self):
        """The number that is asked for is a hundred."""
        few, enough = (with_sample(NOTHING._replace(verified=1e-9), n, heavy=False) for n in (99, 100))
        assert (few.verified, enough.verified) == (1.0, 0.001)
        assert 99 * few.growth == pytest.approx(100.0)

    @pytest.mark.parametrize(("paths", "level"), [(799, 0.001), (800, 1e-9)])
    def test_levels_below_a_thousandth_need_800_paths(self, paths, level):
        """Below, a sample with heavy tails refutes nothing at all."""
        tests = PathTests(1e-9, 1e-9, Reason(""), growth=1.0, limit=1e-9)
        light, heavy = (with_sample(tests, paths, heavy=tails) for tails in (False, True))
        assert (light.verified, light.refuted, light.limit) == (level, level, level)
        assert heavy.refuted == (1e-9 if paths == 800 else 1.0)
        assert light.growth == pytest.approx(max(1.0, 800 / paths))

    @pytest.mark.parametrize(("paths", "guarded"), [(99, False), (100, True)])
    def test_a_guard_needs_a_hundred_paths(self, paths, guarded):
        """Fewer exclude no violation."""
        assert (guard(LOCAL, NOTHING, evidence(paths)).verdict is Verdict.VERIFIED) is guarded


class TestDecisions:
    """Verdicts of paths, and of one step that paths guard."""

    LEVEL = evidence().level

    @pytest.mark.parametrize(("p", "verdict"), [(0.999, Verdict.REFUTED), (1.001, Verdict.INCONCLUSIVE)])
    def test_refuted_at_the_level_of_a_test(self, p, verdict):
        """Paths refute a claim alone, and one that one step verifies."""
        tests = NOTHING._replace(refuted=p * self.LEVEL)
        assert decide(tests, evidence()).verdict is verdict
        assert guard(LOCAL, tests, evidence()).verdict is verdict

    @pytest.mark.parametrize(("p", "verdict"), [(0.999, Verdict.VERIFIED), (1.001, Verdict.INCONCLUSIVE)])
    def test_verified_at_the_level_of_a_test(self, p, verdict):
        """Refuted comes first where both are significant."""
        assert decide(NOTHING._replace(verified=p * self.LEVEL), evidence()).verdict is verdict
        assert decide(NOTHING._replace(verified=0.0, refuted=0.0), evidence()).verdict is Verdict.REFUTED

    @pytest.mark.parametrize(("p", "verdict"), [(0.0099, Verdict.INCONCLUSIVE), (0.0101, Verdict.VERIFIED)])
    def test_a_suspicion_at_one_per_cent_keeps_paths_from_verifying(self, p, verdict):
        """It stays so over all tests of the run."""
        found = decide(NOTHING._replace(verified=1e-9, suspected=p), evidence())
        assert found.verdict is verdict
        assert (found.p_verified == 1.0) is (verdict is Verdict.INCONCLUSIVE)

    @pytest.mark.parametrize(("p", "verdict"), [(0.0099, Verdict.INCONCLUSIVE), (0.0101, Verdict.VERIFIED)])
    def test_paths_unlike_the_claim_do_not_guard_it(self, p, verdict):
        """At 1 less the confidence of the run."""
        assert guard(LOCAL, NOTHING._replace(suspected=p), evidence()).verdict is verdict

    def test_paths_that_would_not_show_an_error_do_not_guard(self):
        """The reason says how many would, if a number of paths does."""
        assert guard(LOCAL, NOTHING._replace(blind=1.0), evidence()).verdict is Verdict.VERIFIED
        more, none = (guard(LOCAL, NOTHING._replace(blind=blind), evidence()) for blind in (1.01, inf))
        assert more.verdict is none.verdict is Verdict.INCONCLUSIVE
        assert (more.settled, none.settled) == (False, True)

    def test_what_one_step_refutes_or_leaves_open_for_good_stays(self):
        """No number of paths changes it."""
        sure = NOTHING._replace(verified=1e-12)
        for said in (LOCAL._replace(verdict=Verdict.REFUTED), too_coarse(1e-3)):
            assert guard(said, sure, evidence()) == said

    def test_paths_do_not_verify_what_one_step_speaks_against(self):
        """They refute it, or verify what one step says nothing of."""
        sure = Opinion(Verdict.VERIFIED, Reason("sure"), p_verified=1e-9)
        against = local_doubt("low", against=True)
        assert beside(against, sure).verdict is Verdict.INCONCLUSIVE
        assert beside(local_doubt("low"), sure).verdict is Verdict.VERIFIED
        assert beside(against, sure._replace(verdict=Verdict.REFUTED)).verdict is Verdict.REFUTED

    @pytest.mark.parametrize(("claim", "verdict"), [(1.0, Verdict.VERIFIED), (1.01, Verdict.INCONCLUSIVE)])
    def test_one_step_verifies_up_to_the_order_of_steps_in_a_row(self, claim, verdict):
        """Above it the claim is open; a refutation stands."""
        assert up_to(1.0, LOCAL, claim, "words").verdict is verdict
        refuted = LOCAL._replace(verdict=Verdict.REFUTED)
        assert up_to(1.0, refuted, claim, "words") == refuted

    def test_a_bound_as_large_as_the_quantity_says_nothing(self):
        """A size that is not known makes no bound void."""
        assert why_vacuous(1.0, 1.0)
        assert not why_vacuous(0.99, 1.0)
        assert not why_vacuous(1.0, 0.0)
        assert not why_vacuous(1.0, float("nan"))


STEP = StrongOrder(1.0, 1.5, 2.0, 1.5, 2.0, True, 0.0, 1.0, 0.0, True, 1.0, True)


class TestOneStep:
    """Local strong orders."""

    @pytest.mark.parametrize(("order", "verdict"), [(0.901, Verdict.VERIFIED), (0.899, Verdict.REFUTED)])
    def test_an_order_a_tenth_below_its_claim_is_refuted(self, order, verdict):
        """Local orders are known to a few hundredths."""
        assert judge_strong(STEP._replace(order=order, ahead=order), 1.0).verdict is verdict

    @pytest.mark.parametrize(("order", "verdict"), [(0.801, Verdict.INCONCLUSIVE), (0.799, Verdict.REFUTED)])
    def test_an_order_within_the_margin_is_open(self, order, verdict):
        """What paths would accept, one step does not refute; it speaks against it."""
        found = judge_strong(STEP._replace(order=order, ahead=order), 1.0, margin=0.2)
        assert found.verdict is verdict
        assert found.speaks_against

    @pytest.mark.parametrize(("ahead", "verdict"), [(0.599, Verdict.INCONCLUSIVE), (0.601, Verdict.REFUTED)])
    def test_an_order_that_moves_by_a_tenth_is_not_settled(self, ahead, verdict):
        """It refutes only if the next one is about the same."""
        assert judge_strong(STEP._replace(order=0.7, ahead=ahead), 1.0).verdict is verdict

    @pytest.mark.parametrize(("typical", "ahead", "verdict"), [(1.0, 0.75, "inconclusive"), (0.8, 0.75, "refuted")])
    def test_an_order_that_rises_at_few_states_is_that_of_a_layer(self, typical, ahead, verdict):
        """It refutes if most states have a low order, too."""
        found = judge_strong(STEP._replace(order=0.7, ahead=ahead, typical=typical), 1.0)
        assert found.verdict == verdict

    @pytest.mark.parametrize(("share", "verdict"), [(0.51, Verdict.REFUTED), (0.5, Verdict.INCONCLUSIVE)])
    def test_a_step_is_inconsistent_at_most_states(self, share, verdict):
        """At fewer states it speaks against the claim."""
        found = judge_strong(STEP._replace(consistent=False, inconsistent_share=share), 1.0)
        assert found.verdict is verdict
        assert found.reason.has(Kind.INCONSISTENT)
        assert found.speaks_against


class Bounded(Scheme):
    """A scheme with claims of several strengths."""

    name = "bounded"
    claims = tuple(
        Claim(measure="invariant", value="unbiased", bound=bound, source="test") for bound in (0.5, 0.1, 0.3)
    ) + tuple(Claim(measure="strong", value=value, source="test") for value in (0.5, 1.0))


class TestCoverage:
    """The strongest claim about a quantity."""

    def test_the_least_bound_and_the_largest_order_are_the_strongest(self):
        """A smaller bound says more, a larger order does."""
        assert claim_for(Bounded(), (), "invariant", "x").claim.value.most == 0.1
        assert claim_for(Bounded(), (), "strong", "x").claim.value.least == 1.0

    def test_exactness_says_more_than_any_order(self):
        """And mean square more than probability."""

        class Exactly(Bounded):
            claims = (
                *Bounded.claims,
                Claim(measure="strong", value="round-off", source="test"),
                Claim(measure="weak", value=1.0, source="test", sense="in probability"),
                Claim(measure="weak", value=1.0, source="test"),
            )

        assert str(claim_for(Exactly(), (), "strong", "x").claim.value) == "round-off"
        assert claim_for(Exactly(), (), "weak", "x").claim.sense == "in mean square"


def low(high, tier=3, verdict=Verdict.REFUTED):
    """Return a finding on paths whose order ends at `high`."""
    return Finding(quantity="p", verdict=verdict, claim=CLAIM, tier=tier, estimate=0.1, low=0.0, high=high)


class TestAgreement:
    """Findings held against each other."""

    @pytest.mark.parametrize(
        ("finding", "stays"),
        [
            (low(0.249), False),
            (low(0.251), True),
            (low(0.249, tier=1), True),
            (low(0.249, verdict=Verdict.INCONCLUSIVE), True),
        ],
    )
    def test_errors_that_do_not_fall_are_those_of_a_wrong_limit(self, finding, stays):
        """The state has no order then, other components and the law may."""
        others = [result(PATHS, *verified("state", "q")), result(LAW, *verified("q^2"))]
        found = left(agreeing(PROBLEM, [result(PATHS, finding), *others]))
        assert found == {("of paths", "q"), ("of law", "q^2")} | ({("of paths", "state")} if stays else set())

    def test_an_interval_below_the_claim_is_remembered_by_its_half_width(self):
        """It lies below if its upper end does; the narrower of two half widths counts."""
        wide = replace(low(0.9), claim=ONE, estimate=0.7)
        assert not lies_below(wide)
        assert lies_below(wide, 0.09)
        assert not lies_below(wide, 0.11)
        assert lies_below(replace(wide, high=0.79), inf)


class TestLevels:
    """Levels that a slope is fitted to."""

    @pytest.mark.parametrize(("failed", "first"), [((0, 0, 0, 0), 0), ((1, 0, 0, 0), 1), ((1, 0, 1, 0), 3)])
    def test_levels_are_finer_than_each_one_that_failed(self, failed, first):
        """Failed paths and truncated steps alike."""
        zeros = np.zeros(4)
        for name, other in (("failed", "truncated"), ("truncated", "failed")):
            levels, why = sound_levels({name: np.array(failed, dtype=float), other: zeros})
            assert levels.tolist() == list(range(first, 4))
            assert bool(why) is any(failed)
