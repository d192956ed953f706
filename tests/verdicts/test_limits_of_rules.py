"""Each limit of a rule of verdicts, from either side: a rule that is turned or a limit that moves fails here."""

from dataclasses import replace
from math import inf
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    EXPLOSION,
    Case,
    EulerMaruyama,
    Explosion,
    Invariant,
    Objection,
    Roughness,
    Strong,
    StrongOrder,
    beside,
    claim_for,
    converges_later,
    gbm,
    hold_back,
    judge_departure,
    judge_order,
    judge_strong,
    of_memory,
    of_smooth,
    path_tests,
    resolve_order,
    rules,
    send,
    sound_levels,
    too_coarse,
    unlike,
    up_to,
    why_moments_diverge,
    why_vacuous,
)
from measures import test_mean_order as mean_orders
from sdaeverify import Claim, Scheme, Settings
from sdaeverify.measuring import (
    Coverage,
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
    judge_claim,
    local_doubt,
    order_tests,
    packed,
    why_not_claimed,
    with_sample,
)
from study.test_agreement import CLAIM, LAW, PATHS, PROBLEM, agreeing, left, result, verified

ONE = Claim(measure="any", value=1.0, source="test")
LOCAL = Opinion(Verdict.VERIFIED, Reason("strong order 1.00"), 1)
NOTHING = PathTests(1.0, 1.0, Reason("figures"))


class Traited(EulerMaruyama):
    """A scheme with claims for every problem, for a trait that growth has, and for one that it has not."""

    name: ClassVar[str] = "traited"
    claims: ClassVar[tuple[Claim, ...]] = (
        ONE,
        replace(ONE, measure="near", when=frozenset({"linear-growth"})),
        replace(ONE, measure="far", when=frozenset({"additive-noise"})),
    )


def claim(value):
    """Return a claim of a value."""
    return replace(ONE, value=value) if isinstance(value, float) else Claim(measure="any", value=value, source="test")


def evidence(paths=4096, **settings):
    """Return evidence of a number of paths, and of nothing else."""
    tally = Tally(sums={"paths": group_sums(np.ones(paths))} if paths else {})
    return Evidence(EulerMaruyama(), gbm(), gbm(), Settings(paths=8192, **settings), tally, Tally())


class TestKnownClaims:
    """Which claim covers a quantity, and whether its measure knows what is claimed."""

    def test_a_claim_is_judged_if_its_measure_knows_the_value(self):
        """Orders are known to measures without words, words to those that list them; nothing else is judged."""
        judged = [
            (value, words, judge_claim(Coverage("x", claim(value)), lambda _: LOCAL, words, tier=2))
            for value in (1.0, "stable", "round-off")
            for words in ((), ("stable",), ("other",))
        ]
        known = {(value, words) for value, words, found in judged if found is LOCAL}
        assert known == {(1.0, ()), ("stable", ("stable",))}
        unknown = [found for *_, found in judged if found is not LOCAL]
        assert {(found.verdict, found.tier, found.reason.kind) for found in unknown} == {
            (Verdict.INCONCLUSIVE, 2, Kind.UNKNOWN_VALUE)
        }

    def test_without_a_claim_nothing_is_judged(self):
        """The quantity is out of scope, for the reason of the gap."""
        found = judge_claim(Coverage("x", None, Reason("a gap")), lambda _: LOCAL)
        assert (found.verdict, str(found.reason)) == (Verdict.OUT_OF_SCOPE, "a gap")

    def test_a_measure_without_a_claim_is_named(self):
        """A claim counts if it is about the measure and its traits are those of the problem."""
        assert why_not_claimed(Traited(), gbm(), "any") == why_not_claimed(Traited(), gbm(), "near") == ""
        assert why_not_claimed(Traited(), gbm(), "far") == "no claim about far here"
        assert why_not_claimed(Traited(), gbm(), "none", "this") == "no claim about this here"

    @pytest.mark.parametrize(
        ("claimed", "measure", "power", "why"),
        [
            (ONE, Strong(), 2.0, "E|x_n|^p grows"),
            (ONE, Strong(), 1.0, ""),
            (None, Strong(), 2.0, ""),
            (replace(ONE, sense="in probability"), Strong(), 2.0, ""),
            (ONE, Invariant(), 2.0, "rare paths"),
            (replace(ONE, sense="in probability"), Invariant(), 2.0, "rare paths"),
        ],
    )
    def test_a_claim_that_rests_on_moments_fails_where_they_explode(self, claimed, measure, power, why):
        """In mean square, or of an invariant law; what was not probed is not known to explode."""
        known = packed(EXPLOSION, Explosion(*map(np.float64, (power, 0.5, 1e3, 1e9))))
        assert why_moments_diverge(claimed, measure, known).startswith(why)
        assert bool(why_moments_diverge(claimed, measure, known)) is bool(why)
        assert why_moments_diverge(claimed, measure, Tally()) == ""


class TestOrders:
    """Orders along paths."""

    @pytest.mark.parametrize(("se", "sure"), [(0.069, True), (0.071, False)])
    def test_an_interval_wider_than_the_margin_verifies_nothing(self, se, sure):
        """Half of the interval at 99 per cent is 2.861 standard errors, and the margin is 0.2."""
        found = order_tests(ONE, Estimate(2.0, se), evidence())
        assert found.verified < 1e-6 if sure else found.verified == 1.0
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
        assert found.verified == (1e-9 if resolved else 1.0)
        assert found.reason.has(Kind.FINER) is not resolved

    def test_a_reason_names_the_lower_order_and_its_share_of_at_most_all(self):
        """Half an order below the claim; a share without bound is told as all of the error."""
        found = resolve_order(NOTHING._replace(verified=1e-9), Order(1.0), Estimate(7.0, 1.0), evidence())
        assert "a term of order 0.5 may make up 100% of the error" in str(found.reason)
        unknown = resolve_order(NOTHING._replace(verified=1e-9), Order(1.0), Estimate(float("nan"), 1.0), evidence())
        assert "may make up 100% of the error" in str(unknown.reason)

    def test_a_bias_adds_to_the_share_of_a_lower_term(self):
        """One whose bias takes it to a tenth needs finer steps, one that its sample takes there more paths."""
        sure = NOTHING._replace(verified=1e-9)
        finer = resolve_order(sure, Order(1.0), Estimate(0.06, 1e-9), evidence(), bias=0.05)
        more = resolve_order(sure, Order(1.0), Estimate(0.06, 0.05), evidence())
        assert finer.reason.has(Kind.FINER)
        assert finer.growth == inf
        assert not more.reason.has(Kind.FINER)
        assert more.growth == pytest.approx(Estimate(0.06, 0.05).growth_to_decide(0.1, 0.01))

    def test_a_lower_term_leaves_an_order_that_paths_do_not_verify_as_it_is(self):
        """Nothing is verified, and the reason is that of the order."""
        found = resolve_order(NOTHING._replace(verified=0.5), Order(1.0), Estimate(0.5, 1e-9), evidence())
        assert found == NOTHING

    def test_the_share_of_a_lower_term_is_between_0_and_1(self):
        """Its bound is the upper end of an interval; nothing is excluded where that is not finite."""
        found = [path_tests.order_resolution(Estimate(share, 1e-9), 0.99) for share in (-0.5, 2.0, float("nan"))]
        assert found == [0.0, 1.0, inf]


class TestCoarseSteps:
    """Levels that hold a refutation back."""

    AGAINST = PathTests(1.0, 1e-9, Reason("figures"), limit=1e-9)

    def levels(self, lost, count):
        """Return the tests after the loss of paths on six levels, the finest `count` of which are used."""
        found = replace(evidence(), health=Tally(sums={"lost": np.array(lost)}))
        return hold_back(self.AGAINST, found, np.arange(6 - count, 6))

    def test_paths_that_are_lost_next_to_few_levels_refute_nothing(self):
        """The tests keep their suspicion, and the limit is as coarse as the order."""
        held = self.levels([0.0, 2.0, 1.0, 0.0, 0.0, 0.0], 3)
        assert (held.refuted, held.suspected, held.limit) == (1.0, 1e-9, 1.0)
        assert "paths are lost at 2 step sizes, only 3 remain" in str(held.reason)

    def test_four_levels_beyond_the_loss_do_refute(self):
        """As do three without any loss."""
        assert self.levels([0.0, 2.0, 0.0, 0.0, 0.0, 0.0], 4) == self.AGAINST
        assert self.levels([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 3) == self.AGAINST

    def test_tests_that_speak_against_nothing_are_left(self):
        """Whatever is lost."""
        some = evidence()
        assert hold_back(NOTHING, some, np.arange(3), "coarse") == NOTHING

    @pytest.mark.parametrize(("verified", "refuted"), [(True, False), (False, True)])
    @pytest.mark.parametrize(
        ("rough", "at_few", "held"),
        [
            (Roughness("drift", lipschitz=True), False, (True, False)),
            (Roughness("drift", lipschitz=True), True, (True, True)),
            (Roughness("drift", lipschitz=True, in_time=True), False, (False, True)),
            (None, True, (False, False)),
        ],
    )
    def test_coefficients_that_are_not_smooth(self, monkeypatch, verified, refuted, rough, at_few, held):
        """They hold back an order above theirs, and a refutation at few states or across a jump in time."""
        monkeypatch.setattr("sdaeverify.verdicts.opinions.rough_coefficient", lambda view: rough)
        said = LOCAL if verified else LOCAL._replace(verdict=Verdict.REFUTED)
        found = of_smooth(said, 1.0, evidence(), at_few=at_few)
        assert (found.verdict is Verdict.INCONCLUSIVE) is held[refuted]
        open_ = LOCAL._replace(verdict=Verdict.INCONCLUSIVE)
        assert of_smooth(open_, 1.0, evidence(), at_few=at_few) == open_


class TestSamples:
    """Sizes of samples."""

    def test_tests_that_reject_nothing_have_p_values_of_one(self):
        """Those of no figures, and that a void bound is verified."""
        none = PathTests.none("too few")
        assert (none.verified, none.refuted, none.suspected, none.growth) == (1.0, 1.0, 1.0, inf)
        void = PathTests(0.0, 0.5, Reason("figures"), growth=2.0).unless_vacuous(1.0, 1.0)
        assert (void.verified, void.refuted, void.growth) == (1.0, 0.5, inf)

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

    @pytest.mark.parametrize(("most", "held"), [(0.9, False), (0.89, True)])
    def test_memory_of_too_low_an_order_leaves_a_verified_order_open(self, most, held):
        """It must reach the least order that counts as the claimed one."""
        found = of_memory(LOCAL, 0.9, most, 1.0)
        assert (found.verdict is Verdict.INCONCLUSIVE) is held
        assert found == LOCAL or "errors of order 0.89" in str(found.reason)

    @pytest.mark.parametrize(("order", "held"), [(0.75, False), (0.76, True)])
    def test_memory_of_nearly_the_same_order_leaves_a_refuted_order_open(self, order, held):
        """It may cancel the errors of a step, unless their order is lower by a quarter."""
        refuted = LOCAL._replace(verdict=Verdict.REFUTED)
        found = of_memory(refuted, 1.4, 1.0, order)
        assert (found.verdict is Verdict.INCONCLUSIVE) is held
        assert found == refuted or "errors of order 1.00" in str(found.reason)

    def test_memory_does_not_excuse_a_step_of_another_equation(self):
        """Nor does it say anything of what is open."""
        wrong = judge_departure("off")
        assert of_memory(wrong, 1.4, 1.0, 1.5) == wrong
        open_ = local_doubt("open")
        assert of_memory(open_, 1.4, 1.0, 1.5) == open_

    def test_a_bound_as_large_as_the_quantity_says_nothing(self):
        """A size that is not known makes no bound void."""
        assert why_vacuous(1.0, 1.0)
        assert not why_vacuous(0.99, 1.0)
        assert not why_vacuous(1.0, 0.0)
        assert not why_vacuous(1.0, float("nan"))


class TestMeans:
    """Differences of means."""

    @pytest.mark.parametrize(("jitter", "shown"), [(0.01, True), (0.02, False)])
    def test_a_difference_below_three_standard_errors_shows_no_order(self, jitter, shown):
        """It is 3.5 and 2.1 standard errors here."""
        order = mean_orders.found(0.1 * mean_orders.H, jitter=jitter)
        assert 2.0 < order.resolved < 3.6
        assert (order.resolved > 3.0) is shown
        assert ("below sampling noise" in str(order.tests.reason)) is not shown

    @pytest.mark.parametrize(("size", "refuted"), [(84.0, False), (38.0, True)])
    def test_an_error_of_a_quarter_of_the_mean_refutes_no_order(self, size, refuted):
        """The last difference is 0.30 and 0.22 of the mean."""
        errors = size * mean_orders.H**0.5
        order = mean_orders.found(errors, seen=mean_orders.problem(truth=False))
        assert bool((errors[-2] - errors[-1]) / (mean_orders.LIMIT + errors[-1]) < 0.25) is refuted
        assert (order.tests.refuted < 1e-6) is refuted


STEP = StrongOrder(1.0, 1.5, 2.0, typical=1.0, plateau_h=0.0, means=True, ahead=1.0)


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
        assert ("refuted below 0.8" in str(found.reason)) is (verdict is Verdict.INCONCLUSIVE)

    @pytest.mark.parametrize(("ahead", "verdict"), [(0.599, Verdict.INCONCLUSIVE), (0.601, Verdict.REFUTED)])
    def test_an_order_that_moves_by_a_tenth_is_not_settled(self, ahead, verdict):
        """It refutes only if the next one is about the same."""
        assert judge_strong(STEP._replace(order=0.7, ahead=ahead), 1.0).verdict is verdict

    @pytest.mark.parametrize(("typical", "ahead", "verdict"), [(1.0, 0.75, "inconclusive"), (0.8, 0.75, "refuted")])
    def test_an_order_that_rises_at_few_states_is_that_of_a_layer(self, typical, ahead, verdict):
        """It refutes if most states have a low order, too."""
        found = judge_strong(STEP._replace(order=0.7, ahead=ahead, typical=typical), 1.0)
        assert found.verdict == verdict

    def test_a_step_that_deviates_from_the_equation_is_refuted(self):
        """Whatever its order is."""
        found = judge_strong(STEP._replace(departure="off"), 1.0)
        assert found.verdict is Verdict.REFUTED
        assert found.reason.has(Kind.INCONSISTENT)

    def test_an_opinion_needs_an_order_and_a_claim_of_one(self):
        """Without one of them there is none."""
        assert judge_order(evidence(), None, STEP) is None
        assert judge_order(evidence(), claim("round-off"), STEP) is None
        assert judge_order(evidence(), ONE, None) is None
        assert judge_order(evidence(), ONE, STEP).verdict is Verdict.VERIFIED

    @pytest.mark.parametrize(("memory", "verdict"), [(0.91, Verdict.VERIFIED), (0.89, Verdict.INCONCLUSIVE)])
    def test_memory_counts_up_to_the_tolerance(self, memory, verdict):
        """An order a tenth below the claim counts as the claimed one."""
        assert judge_order(evidence(), ONE, STEP._replace(memory=memory)).verdict is verdict

    @pytest.mark.parametrize(("typical", "verdict"), [(0.91, Verdict.INCONCLUSIVE), (0.89, Verdict.REFUTED)])
    def test_a_kink_excuses_a_low_order_at_few_states(self, monkeypatch, typical, verdict):
        """Most of them have the claimed order up to the tolerance."""
        kink = Roughness("drift", lipschitz=True)
        monkeypatch.setattr("sdaeverify.verdicts.opinions.rough_coefficient", lambda view: kink)
        low = STEP._replace(order=0.5, ahead=0.5, typical=typical)
        assert judge_order(evidence(), ONE, low).verdict is verdict

    @pytest.mark.parametrize(("p2", "verdict"), [(1.41, Verdict.INCONCLUSIVE), (1.39, Verdict.REFUTED)])
    def test_a_mean_that_changes_its_sign_refutes_nothing(self, p2, verdict):
        """If the root mean square has the claimed order."""
        turning = STEP._replace(order=0.5, ahead=0.5, typical=0.5, turns=True, p2=p2)
        assert judge_strong(turning, 1.0).verdict is verdict

    @pytest.mark.parametrize(("ahead", "verdict"), [(0.91, Verdict.VERIFIED), (0.89, Verdict.INCONCLUSIVE)])
    def test_an_order_that_falls_below_its_claim_at_the_next_size_is_not_verified(self, ahead, verdict):
        """It speaks against the claim, and as a wrong limit if no order is left."""
        found = judge_strong(STEP._replace(ahead=ahead), 1.0)
        assert found.verdict is verdict
        assert found.speaks_against is (verdict is Verdict.INCONCLUSIVE)
        none = judge_strong(STEP._replace(ahead=-0.01), 1.0)
        assert none.reason.has(Kind.INCONSISTENT)
        assert not judge_strong(STEP._replace(ahead=0.01), 1.0).reason.has(Kind.INCONSISTENT)

    def test_low_orders_of_which_one_has_settled_refute(self):
        """Each kind of defect, and each group of states, has to be changing."""
        changing, settled = (0.5, 0.8), (0.7, 0.7)
        low = STEP._replace(order=0.5, ahead=0.7, typical=0.5)
        assert judge_strong(low._replace(each=(changing, (1.0, 1.0))), 1.0).verdict is Verdict.INCONCLUSIVE
        assert judge_strong(low._replace(each=(changing, settled)), 1.0).verdict is Verdict.REFUTED
        assert judge_strong(low._replace(each=(changing,)), 1.0, sharp=False).verdict is Verdict.INCONCLUSIVE

    @pytest.mark.parametrize(("now", "ahead"), [(0.5, 0.8), (0.8, 0.5)])
    def test_a_low_order_that_falls_speaks_against_its_claim(self, now, ahead):
        """One that rises does not."""
        found = judge_strong(STEP._replace(order=now, ahead=ahead, typical=0.5), 1.0)
        assert found.verdict is Verdict.INCONCLUSIVE
        assert found.speaks_against is (ahead < now)

    def test_a_step_that_cannot_be_compared_verifies_nothing(self):
        """Its own differences have an order of any equation; they still refute."""
        unknown = STEP._replace(compared=False)
        assert judge_strong(unknown, 1.0).verdict is Verdict.INCONCLUSIVE
        assert not judge_strong(unknown, 1.0).speaks_against
        assert judge_strong(unknown._replace(order=0.5, ahead=0.5), 1.0).verdict is Verdict.REFUTED

    @pytest.mark.parametrize(("order", "converges"), [(0.101, True), (0.099, False)])
    def test_an_order_below_a_tenth_is_none(self, order, converges):
        """The least order is 1/2. An order at much shorter steps only is one of steps that a run does not take."""
        some = STEP._replace(order=order, ahead=order)
        assert some.converges is converges
        assert converges_later(some, STEP) is not converges
        assert not converges_later(STEP, STEP)
        assert not converges_later(some, some)


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


class TestLevels:
    """Levels that a slope is fitted to."""

    @pytest.mark.parametrize(("failed", "seen"), [([3, 0], True), ([3, 3], False)])
    def test_an_order_is_never_seen_if_all_levels_go_wrong(self, failed, seen):
        """The remark says so then, and only then."""
        _, remarks = sound_levels({"failed": np.array(failed), "truncated": np.zeros(2)})
        assert ("be observed" not in str(remarks)) is seen

    def test_the_end_of_a_solution_is_a_mean_over_the_paths_that_end(self):
        """Times are summed over the paths, at the finest level that loses some."""
        none = {"failed": np.zeros(3), "truncated": np.zeros(3)}
        lost = {"singular": np.array([4.0, 2.0, 0.0]), "singular_time": np.array([1.0, 1.4, 0.0])}
        assert "on 2 paths, on average at t = 0.7" in str(sound_levels({**none, **lost})[1])

    @pytest.mark.parametrize(("failed", "first"), [((0, 0, 0, 0), 0), ((1, 0, 0, 0), 1), ((1, 0, 1, 0), 3)])
    def test_levels_are_finer_than_each_one_that_failed(self, failed, first):
        """Failed paths and truncated steps alike."""
        zeros = np.zeros(4)
        for name, other in (("failed", "truncated"), ("truncated", "failed")):
            levels, why = sound_levels({name: np.array(failed, dtype=float), other: zeros})
            assert levels.tolist() == list(range(first, 4))
            assert bool(why) is any(failed)


SURE = Finding(quantity="x", verdict=Verdict.VERIFIED, claim=ONE, estimate=1.0, low=0.9, high=1.1, p_verified=1e-9)


class TestRules:
    """What becomes of a verified finding."""

    @pytest.mark.parametrize(("tier", "settled"), [(1, True), (3, False)])
    def test_controls_that_more_paths_may_mend_leave_paths_to_draw(self, tier, settled):
        """One step is not changed by more of them."""
        found = send(replace(SURE, tier=tier), Case(objection=Objection("the control is not refuted")))
        assert (found.verdict, found.settled) == (Verdict.INCONCLUSIVE, settled)
        assert str(found.reason).startswith("the control is not refuted")
        assert found.p_verified == 1.0

    @pytest.mark.parametrize("verdict", [Verdict.ERROR, Verdict.NOT_RUN])
    def test_controls_of_which_nothing_is_known_end_the_matter(self, verdict):
        """The verdict is theirs, and the reason says that the claim is not verified."""
        found = send(SURE, Case(objection=Objection("the control died", verdict)))
        assert (found.verdict, found.settled) == (verdict, True)
        assert str(found.reason).startswith("not verified: the control died")

    def test_a_suspected_problem_refutes_nothing(self):
        """What is refuted becomes an error of the problem; what is verified stays so."""
        suspicion = Case(suspicion="a control is refuted")
        refuted = send(replace(SURE, verdict=Verdict.REFUTED, p_refuted=0.0), suspicion)
        assert (refuted.verdict, refuted.p_refuted) == (Verdict.ERROR, 1.0)
        assert send(SURE, suspicion).verdict is Verdict.VERIFIED
        assert send(SURE, suspicion).excluded == {Verdict.REFUTED}

    @pytest.mark.parametrize("verdict", [Verdict.VERIFIED, Verdict.INCONCLUSIVE, Verdict.REFUTED])
    def test_diverging_moments_verify_nothing(self, verdict):
        """What is refuted stays refuted."""
        found = send(replace(SURE, verdict=verdict), Case(diverges="moments grow"))
        assert found.verdict is (Verdict.INCONCLUSIVE if verdict is Verdict.VERIFIED else verdict)
        assert Verdict.VERIFIED in found.excluded

    @pytest.mark.parametrize(
        ("tier", "verdict", "left"),
        [
            (1, Verdict.REFUTED, Verdict.INCONCLUSIVE),
            (3, Verdict.REFUTED, Verdict.REFUTED),
            (3, Verdict.VERIFIED, Verdict.INCONCLUSIVE),
            (3, Verdict.DIVERGED, Verdict.DIVERGED),
        ],
    )
    def test_only_paths_refute_what_the_solution_may_not_last_for(self, tier, verdict, left):
        """Where the solution ends stands behind the reason, once."""
        end = Reason("the solution ends", Kind.LOST_INDEX)
        found = send(replace(SURE, tier=tier, verdict=verdict, reason=Reason("seen")), Case(end=end))
        assert found.verdict is left
        assert str(found.reason) == ("seen; the solution ends" if left is Verdict.INCONCLUSIVE else "seen")
        again = send(replace(SURE, reason=end), Case(end=end))
        assert str(again.reason) == "the solution ends"

    def test_looks_share_a_level(self):
        """P-values are multiplied by their number, and are at most 1; what is no test stays none."""
        found = send(replace(SURE, p_verified=0.2, p_refuted=0.001), Case(looks=6))
        assert (found.p_verified, found.p_refuted) == (1.0, pytest.approx(0.006))
        assert np.isnan(send(replace(SURE, p_verified=float("nan")), Case(looks=6)).p_verified)

    @pytest.mark.parametrize(("seen", "verdict"), [(0.021, Verdict.INCONCLUSIVE), (0.019, Verdict.VERIFIED)])
    def test_a_policy_bounds_the_error_that_may_be_overlooked(self, seen, verdict):
        """An error that nobody asks about stays verified."""
        assert send(replace(SURE, resolution=seen), Case(resolution=0.02)).verdict is verdict
        assert send(replace(SURE, resolution=inf), Case()).verdict is Verdict.VERIFIED

    def test_what_waits_for_finer_levels_is_open(self):
        """And may be decided by them."""
        found = send(SURE, Case(finer=True))
        assert (found.verdict, found.settled) == (Verdict.INCONCLUSIVE, False)

    @pytest.mark.parametrize("settled", [True, False])
    def test_why_sampling_stopped_is_said_of_what_more_paths_might_decide(self, settled):
        """Nothing else changes."""
        found = send(
            replace(SURE, verdict=Verdict.INCONCLUSIVE, settled=settled, reason=Reason("seen")),
            Case(stopped="interrupted"),
        )
        assert str(found.reason) == ("seen" if settled else "interrupted; seen")
        assert str(send(SURE, Case(stopped="interrupted")).reason) == ""

    @pytest.mark.parametrize(
        ("tier", "verdict", "significant", "left"),
        [
            (3, Verdict.VERIFIED, {Verdict.VERIFIED}, Verdict.VERIFIED),
            (3, Verdict.VERIFIED, set(), Verdict.INCONCLUSIVE),
            (1, Verdict.VERIFIED, set(), Verdict.VERIFIED),
            (3, Verdict.INCONCLUSIVE, {Verdict.VERIFIED}, Verdict.VERIFIED),
            (3, Verdict.INCONCLUSIVE, {Verdict.VERIFIED, Verdict.REFUTED}, Verdict.REFUTED),
            (3, Verdict.INCONCLUSIVE, set(), Verdict.INCONCLUSIVE),
            (3, Verdict.DIVERGED, {Verdict.REFUTED}, Verdict.DIVERGED),
            (3, Verdict.OUT_OF_SCOPE, {Verdict.REFUTED}, Verdict.OUT_OF_SCOPE),
        ],
    )
    def test_all_tests_of_a_run_share_its_level(self, tier, verdict, significant, left):
        """Verdicts of paths are kept, taken back or given; one step is no test."""
        found = send(replace(SURE, tier=tier, verdict=verdict), Case(significant=frozenset(significant)))
        assert found.verdict is left
        assert send(replace(SURE, p_verified=float("nan")), Case(significant=frozenset())).verdict is Verdict.VERIFIED

    @pytest.mark.parametrize(("verdict", "left"), [(Verdict.VERIFIED, "seen"), (Verdict.REFUTED, "seen; open")])
    def test_a_limit_that_was_open_alone_is_shown_among_all_tests(self, verdict, left):
        """The reason loses what was open of the limit if the claim is verified, and keeps it if it is refuted."""
        reason = Reason("seen").then(Reason("open", Kind.LIMIT)).then(Reason("more paths", Kind.MORE_PATHS))
        open_ = replace(SURE, verdict=Verdict.INCONCLUSIVE, reason=reason)
        found = send(open_, Case(significant=frozenset({verdict})))
        assert str(found.reason) == f"{left}; significant after correction for all tests of this run"

    def test_a_wrong_limit_in_one_quantity_holds_for_the_cell(self):
        """What is verified is taken back, and nothing else."""
        off = replace(SURE, quantity="y", verdict=Verdict.REFUTED, reason=Reason("off", Kind.WRONG_LIMIT))
        low_order = replace(off, reason=Reason("low", Kind.ORDER))
        open_ = replace(SURE, quantity="z", verdict=Verdict.INCONCLUSIVE)
        assert [f.verdict for f in rules.withhold_in_doubt([SURE, off, open_])] == [
            Verdict.INCONCLUSIVE,
            Verdict.REFUTED,
            Verdict.INCONCLUSIVE,
        ]
        assert rules.withhold_in_doubt([SURE, low_order])[0].verdict is Verdict.VERIFIED
