"""Deciding a claim by paths, alone and as a guard of one step: verdict, reason, and whether sampling may stop."""

from dataclasses import replace
from math import inf, isnan, nextafter

import numpy as np
import pytest

from facade import ask_to_resolve, beside, diverged, hold_back, judge_departure, of_memory, rounded_up
from sdaeverify.measuring import Coverage, Kind, Opinion, Reason, Tally, Verdict, decide, guard, local_doubt, no_fit
from verdicts.test_limits_of_rules import LOCAL, NOTHING, ONE, evidence

# The evidence has 4096 paths unless a test says otherwise, and the run takes at most 8192.
LEVEL = evidence().level
FINER = Reason("figures").then(Reason("finer steps", Kind.FINER))


def just(value):
    """Return the neighbours of a number and the number itself, in rising order."""
    return nextafter(value, 0.0), value, nextafter(value, inf)


def losing(*lost):
    """Return evidence that loses numbers of paths, one for each level."""
    return replace(evidence(), health=Tally(sums={"lost": np.array(lost)}))


class TestPathsAlone:
    """Verdicts of `decide`."""

    def test_a_claim_is_refuted_up_to_the_level(self):
        """The p-values are kept, and no more paths are requested."""
        found = [decide(NOTHING._replace(refuted=p, verified=0.4, growth=2.0), evidence()) for p in just(LEVEL)]
        assert [each.verdict for each in found] == [Verdict.REFUTED, Verdict.REFUTED, Verdict.INCONCLUSIVE]
        assert (found[0].p_refuted, found[0].p_verified) == (just(LEVEL)[0], 0.4)
        assert (str(found[0].reason), found[0].settled, found[0].tier) == ("figures", True, 3)

    def test_a_claim_is_verified_up_to_the_level(self):
        """The p-values are kept, and no more paths are requested."""
        found = [decide(NOTHING._replace(verified=p, refuted=0.4, growth=2.0), evidence()) for p in just(LEVEL)]
        assert [each.verdict for each in found] == [Verdict.VERIFIED, Verdict.VERIFIED, Verdict.INCONCLUSIVE]
        assert (found[0].p_verified, found[0].p_refuted) == (just(LEVEL)[0], 0.4)
        assert (str(found[0].reason), found[0].settled, found[0].excluded) == ("figures", True, frozenset())

    def test_a_suspicion_of_one_per_cent_withholds_verification(self):
        """No correction for several tests gives it back, because its p-value is 1 and the verdict is excluded."""
        sure = NOTHING._replace(verified=1e-9)
        found = [decide(sure._replace(suspected=p), evidence()) for p in just(0.01)]
        assert [each.verdict for each in found] == [Verdict.INCONCLUSIVE, Verdict.INCONCLUSIVE, Verdict.VERIFIED]
        assert [each.p_verified for each in found] == [1.0, 1.0, 1e-9]
        assert [each.excluded for each in found] == [{Verdict.VERIFIED}, {Verdict.VERIFIED}, frozenset()]

    def test_a_suspicion_does_not_withhold_refutation(self):
        """The claim is refuted by the same paths."""
        assert decide(NOTHING._replace(refuted=LEVEL, suspected=1e-9), evidence()).verdict is Verdict.REFUTED


class TestStopping:
    """Whether sampling may stop, and what is requested."""

    @pytest.mark.parametrize(
        ("paths", "growth", "settled"),
        [
            (4096, nextafter(2.0, 3.0), True),  # half of the budget shows that the budget is too small
            (4096, 2.0, False),  # the budget is just enough
            (4095, 4.0, False),  # less than half of the budget
            (8191, 4.0, True),
            (8192, 4.0, False),  # nothing is left to save
        ],
    )
    def test_sampling_stops_at_half_of_a_budget_that_is_too_small(self, paths, growth, settled):
        """The last look costs as much as all others, and would not decide. The same holds for a guard."""
        assert decide(NOTHING._replace(growth=growth), evidence(paths)).settled is settled
        assert guard(LOCAL, NOTHING._replace(blind=growth), evidence(paths)).settled is settled

    @pytest.mark.parametrize("paths", [0, 100, 4096])
    def test_sampling_stops_where_more_paths_cannot_decide(self, paths):
        """Unless finer levels can: those need paths, too."""
        assert decide(NOTHING, evidence(paths)).settled
        assert not decide(NOTHING._replace(reason=FINER), evidence(paths)).settled

    def test_before_any_path_is_drawn_a_growth_says_nothing(self):
        """Then only levels decide whether sampling may stop, and no number of paths is requested."""
        found = decide(NOTHING._replace(growth=2.0), evidence(0))
        assert (found.settled, str(found.reason)) == (True, "figures")
        assert not decide(NOTHING._replace(reason=FINER, growth=2.0), evidence(0)).settled

    def test_a_decided_claim_needs_no_finer_levels(self):
        """Even if its reason names them."""
        for p in ({"verified": LEVEL}, {"refuted": LEVEL}):
            assert decide(NOTHING._replace(reason=FINER, **p), evidence()).settled

    def test_a_remedy_is_requested_in_place_of_paths(self):
        """A truth, for instance."""
        some = NOTHING._replace(growth=1.5)
        assert str(decide(some._replace(remedy=Reason("a truth")), evidence()).reason) == "figures; a truth"
        assert str(decide(some, evidence()).reason) == "figures; about 6200 paths would decide (--paths)"

    def test_paths_are_requested_by_their_number_if_their_growth_is_above_1(self):
        """Rounded up, and as a number that no run takes if it exceeds the maximum; infinite growth requests none."""
        growths = (just(1.0)[2], 1.4, 1e9, inf)
        found = [decide(NOTHING._replace(growth=growth), evidence()).reason for growth in growths]
        beyond = "more than 1e+09 paths, the maximum of --paths, would be needed"
        asked = ("about 4100 paths would decide (--paths)", "about 5800 paths would decide (--paths)", beyond)
        assert [str(each) for each in found] == [*(f"figures; {each}" for each in asked), "figures"]
        assert [each.paths for each in found] == [4100.0, 5800.0, 4.1e12, 0.0]

    @pytest.mark.parametrize(
        ("verified", "refuted", "asked"),
        [
            (just(LEVEL)[1], 1.0, "; the same paths are evidence against the claim (p = 0.005): finer steps"),
            (just(LEVEL)[2], just(0.5)[0], "; more paths would decide (--paths)"),
            (just(LEVEL)[2], 0.5, ""),
            (just(LEVEL)[2], 0.7, ""),
        ],
    )
    def test_paths_that_should_suffice_but_do_not_are_explained(self, verified, refuted, asked):
        """By a suspicion of the same paths, or by a second fit that is nearly sure of an order below the bound."""
        tests = NOTHING._replace(growth=1.0, verified=verified, refuted=refuted, suspected=0.005)
        found = decide(tests, evidence())
        assert found.verdict is Verdict.INCONCLUSIVE
        assert str(found.reason).startswith(f"figures{asked}")
        assert bool(asked) is (str(found.reason) != "figures")


class TestGuard:
    """Paths that guard one step."""

    def test_paths_refute_up_to_the_level_what_one_step_verifies(self):
        """The reason is theirs, and names what one step says; the p-value is kept."""
        found = [guard(LOCAL, NOTHING._replace(refuted=p), evidence()) for p in just(LEVEL)]
        assert [each.verdict for each in found] == [Verdict.REFUTED, Verdict.REFUTED, Verdict.INCONCLUSIVE]
        assert str(found[1].reason) == "figures, although strong order 1.00"
        assert (found[1].tier, found[1].settled, found[1].p_refuted) == (3, True, LEVEL)
        assert isnan(found[1].p_verified)

    def test_paths_that_agree_leave_the_opinion_of_one_step(self):
        """With their p-value."""
        assert guard(LOCAL, NOTHING._replace(refuted=0.4), evidence())[:4] == LOCAL[:4]
        assert guard(LOCAL, NOTHING._replace(refuted=0.4), evidence()).p_refuted == 0.4

    @pytest.mark.parametrize("local", [None, local_doubt("open")])
    def test_paths_decide_what_one_step_leaves_open(self, local):
        """Either way; the reason of one step follows that of the paths."""
        for p, verdict in (("verified", Verdict.VERIFIED), ("refuted", Verdict.REFUTED)):
            found = guard(local, NOTHING._replace(**{p: 1e-9}), evidence())
            assert (found.verdict, found.tier) == (verdict, 3)
            assert str(found.reason) == ("figures; open" if local else "figures")

    def test_too_few_paths_are_named(self):
        """A hundred are needed, and without them sampling may stop."""
        found = guard(LOCAL, NOTHING._replace(refuted=0.4), evidence(99))
        expected = "strong order 1.00; 99 paths are too few to exclude a violation, 100 are needed"
        assert (found.verdict, str(found.reason)) == (Verdict.INCONCLUSIVE, expected)
        assert (found.tier, found.settled, found.p_refuted) == (3, True, 0.4)

    @pytest.mark.parametrize("confidence", [0.95, 0.99])
    def test_paths_are_unlike_the_claim_up_to_the_complement_of_the_confidence(self, confidence):
        """Both kinds of evidence count, and sampling goes on."""
        for kind in ("refuted", "suspected"):
            tests = [NOTHING._replace(**{kind: p}) for p in just(1.0 - confidence)]
            found = [guard(LOCAL, each, evidence(confidence=confidence)) for each in tests]
            assert [each.verdict for each in found] == [Verdict.INCONCLUSIVE, Verdict.INCONCLUSIVE, Verdict.VERIFIED]
            assert [each.settled for each in found] == [False, False, True]
            assert found[0].p_refuted == tests[0].refuted

    @pytest.mark.parametrize(
        ("suspected", "refuted", "finer"),
        [
            (just(LEVEL)[1], 1.0, True),
            (just(LEVEL)[2], 1.0, False),
            (LEVEL, just(0.01)[2], True),
            (LEVEL, 0.01, False),
        ],
    )
    def test_a_significant_contradiction_that_is_held_back_asks_for_finer_steps(self, suspected, refuted, finer):
        """Any other asks for more paths."""
        reason = guard(LOCAL, NOTHING._replace(suspected=suspected, refuted=refuted), evidence()).reason
        assert "paths do not agree with the claim at these step sizes: figures" in str(reason)
        assert (reason.has(Kind.FINER), reason.has(Kind.MORE_PATHS)) == (finer, not finer)

    @pytest.mark.parametrize(
        ("blind", "asked"),
        [
            (just(1.0)[2], "--paths 4100 would"),
            (2.0, "--paths 8200 would"),
            (1e9, "nor could 1e+09, the maximum of --paths"),
            (inf, "nor could more paths"),
        ],
    )
    def test_paths_that_would_not_show_an_error_are_too_few(self, blind, asked):
        """The reason says how many would, if any number does."""
        found = guard(LOCAL, NOTHING._replace(blind=blind), evidence())
        assert found.verdict is Verdict.INCONCLUSIVE
        assert str(found.reason) == f"strong order 1.00; 4096 paths cannot exclude a violation, {asked}"

    def test_one_doubt_is_named_at_a_time(self):
        """Too few paths come before paths unlike the claim, and these before paths that would not show an error."""
        doubtful = NOTHING._replace(suspected=1e-9, blind=inf)
        few, unlike = (str(guard(LOCAL, doubtful, evidence(paths)).reason) for paths in (99, 100))
        assert few.startswith("strong order 1.00; 99 paths are too few")
        assert unlike.startswith("strong order 1.00; paths do not agree")
        assert "exclude a violation" not in unlike


class TestBesideOneStep:
    """Opinions of paths beside one step that leaves a claim open."""

    AGAINST = local_doubt("low", against=True)

    def test_a_verdict_against_which_one_step_speaks_is_withheld(self):
        """Its p-value is 1, so that no correction for several tests gives it back."""
        found = beside(self.AGAINST, Opinion(Verdict.VERIFIED, Reason("sure"), p_verified=1e-9, p_refuted=0.4))
        assert (found.verdict, str(found.reason)) == (Verdict.INCONCLUSIVE, "low, although sure")
        assert (found.p_verified, found.p_refuted, found.excluded) == (1.0, 0.4, {Verdict.VERIFIED})

    @pytest.mark.parametrize("verdict", [Verdict.REFUTED, Verdict.INCONCLUSIVE])
    def test_no_paths_are_requested_for_a_verdict_that_one_step_excludes(self, verdict):
        """Nor a truth; what paths exclude stays excluded."""
        asked = Reason("seen").then(Reason("more", Kind.MORE_PATHS)).then(Reason("truth", Kind.TRUTH))
        found = beside(self.AGAINST, Opinion(verdict, asked, excluded=frozenset({Verdict.DIVERGED})))
        assert (found.verdict, str(found.reason), found.p_verified) == (verdict, "seen; low", 1.0)
        assert found.excluded == {Verdict.VERIFIED, Verdict.DIVERGED}

    def test_a_neutral_doubt_is_a_remark(self):
        """The p-values and what is requested stay."""
        sure = Opinion(Verdict.VERIFIED, Reason("sure"), p_verified=1e-9)
        assert beside(local_doubt("open"), sure) == sure._replace(reason=Reason.of("sure", "open"))
        assert beside(None, sure) == sure


class TestMemory:
    """Verdicts of one step of a scheme with memory, whose errors have order 1."""

    @pytest.mark.parametrize(("bar", "held"), [*zip(just(1.0), (False, False, True), strict=True)])
    def test_a_verified_order_is_withheld_above_the_order_of_memory(self, bar, held):
        """The order of one step does not matter."""
        for order in (0.5, 2.0):
            assert (of_memory(LOCAL, bar, 1.0, order) != LOCAL) is held

    @pytest.mark.parametrize(("order", "held"), [(0.749, False), (0.75, False), (0.751, True)])
    def test_a_refuted_order_is_withheld_from_a_quarter_below_the_order_of_memory(self, order, held):
        """The claimed order does not matter."""
        refuted = LOCAL._replace(verdict=Verdict.REFUTED)
        for bar in (0.5, 2.0):
            assert (of_memory(refuted, bar, 1.0, order) != refuted) is held

    def test_what_is_withheld_is_neutral(self):
        """Paths may decide it, and the reason keeps that of one step."""
        found = of_memory(LOCAL, 2.0, 1.0, 1.0)
        assert (found.verdict, found.excluded, found.tier) == (Verdict.INCONCLUSIVE, frozenset(), 1)
        assert str(found.reason) == "strong order 1.00; but the scheme's memory adds errors of order 1.00 to a run"

    def test_a_step_of_another_equation_stays_refuted(self):
        """As any verdict without memory, and any other than verified and refuted."""
        for stays in (judge_departure("off"), local_doubt("open"), LOCAL._replace(verdict=Verdict.ERROR)):
            assert of_memory(stays, 2.0, 1.0, 1.0) == stays
        assert of_memory(LOCAL, 2.0, inf, 1.0) == LOCAL


class TestHeldBack:
    """Refutations on levels that look too coarse."""

    @pytest.mark.parametrize(("p", "growth"), [*zip(just(0.01), (2.0, 2.0, 5.0), strict=True)])
    @pytest.mark.parametrize("kind", ["refuted", "suspected"])
    def test_paths_that_would_confirm_the_coarse_levels_matter_from_one_per_cent_on(self, kind, p, growth):
        """A weaker contradiction leaves the number of paths that the claim itself needs."""
        held = hold_back(NOTHING._replace(growth=5.0, **{kind: p}), losing(0.0), np.arange(3, 6), "coarse", 2.0)
        assert (held.growth, held.refuted, held.suspected) == (growth, 1.0, p)
        assert str(held.reason) == "figures; coarse"


class TestWithoutTruth:
    """Tests of a limit that no truth of the problem confirms."""

    @pytest.mark.parametrize("reached", [True, False])
    @pytest.mark.parametrize(("p", "growth"), [*zip(just(LEVEL), (inf, inf, 2.0), strict=True)])
    def test_nothing_is_verified_and_a_truth_is_requested_where_paths_do_not_refute(self, reached, p, growth):
        """Paths may still refute an estimate that does not agree with the claim and is not above its bound."""
        found = NOTHING._replace(verified=p, refuted=0.4, growth=2.0).without_truth(LEVEL, "a mean", reached=reached)
        assert (found.verified, found.refuted, found.growth) == (1.0, 0.4, growth)
        asked = "no number of paths can verify the claim unless a mean is attached to the problem"
        assert str(found.remedy) == (asked if reached or growth == inf else "")


class TestNumbers:
    """Numbers that reasons name."""

    @pytest.mark.parametrize(
        ("number", "told"),
        [(7.2, "8"), (10.0, "10"), (12.1, "13"), (1000.0, "1000"), (1024.0, "1100"), (12345.0, "13000")],
    )
    def test_two_digits_are_rounded_up(self, number, told):
        """So that 1024 paths never read as 1000."""
        assert rounded_up(number) == told

    @pytest.mark.parametrize(
        ("signal", "asked"),
        [
            (just(1.0)[0], "below one standard error, the number of paths needed cannot be predicted"),
            (1.0, "about 9000 paths would resolve the bias (--paths)"),
            (1.5, "about 4000 paths would resolve the bias (--paths)"),
        ],
    )
    def test_paths_resolve_a_bias_by_the_square_of_its_standard_errors(self, signal, asked):
        """Three are needed of 1000 paths; a bias of less than one may be noise alone."""
        assert str(ask_to_resolve(signal, 3.0, 1000)) == asked

    @pytest.mark.parametrize(("paths", "asked"), [(10**9, "about 1000000000"), (10**9 + 1, "more than 1e+09")])
    def test_no_run_takes_more_than_a_billion_paths(self, paths, asked):
        """Beyond it the reason names the maximum."""
        assert str(ask_to_resolve(3.0, 3.0, paths)).startswith(asked)


class TestTooFewLevels:
    """Quantities without a slope."""

    @pytest.mark.parametrize(("lost", "verdict"), [(0.0, Verdict.VERIFIED), (1.0, Verdict.DIVERGED)])
    def test_one_lost_path_diverges(self, lost, verdict):
        """The reason stays."""
        assert diverged(LOCAL, lost) == LOCAL._replace(verdict=verdict)

    @pytest.mark.parametrize(("claim", "verdict"), [(ONE, Verdict.INCONCLUSIVE), (None, Verdict.OUT_OF_SCOPE)])
    def test_two_levels_leave_a_claim_open(self, claim, verdict):
        """The reason says why levels were left out, and paths lost at the finest level alone diverge."""
        for lost, left in (((1.0, 0.0), verdict), ((0.0, 1.0), Verdict.DIVERGED)):
            found = no_fit(losing(*lost), Coverage("x", claim), Reason("paths are lost"))
            assert found.verdict is left
            assert str(found.reason) == "fewer than 3 step sizes can be fitted: paths are lost"
