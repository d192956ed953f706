"""Rules of the findings along paths, each from either side of its limit."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cells import claimant
from facade import ErrorObserver, gbm, level_rows, path_order, quantities_of, tally_errors
from measures.test_strong import ONE, SETTINGS, H, blind, errors, health
from sdaeverify.measuring import Estimate, Evidence, Kind, PathTests, Reason, Snapshot, Verdict
from sdaeverify.numerics.statistics import EPS

ALL = np.arange(6)
FINEST = ALL[2:]


def evidence_of(levels, *, problem=None, blurred=None, health_of=None, moved=1.0, claims=(ONE,)):
    """Return the evidence on x, whose error of each level and path is given, and which moves by `moved`."""
    paths = len(levels[0])
    settings = replace(SETTINGS, paths=paths)
    observer = ErrorObserver({"x": np.zeros((1, paths))}, settings)
    coarser = None if blurred is None else {"x": moved + blurred[None]}
    truth = {"x": np.full((1, paths), moved)}
    observer.after_coarsest_step(Snapshot([{"x": moved + level[None]} for level in levels], truth, coarser))
    problem = problem or gbm()
    return Evidence(claimant(*claims), problem, problem, settings, observer.tally(), health_of or health())


def quantity_of(levels, **given):
    """Return the quantity x of such evidence."""
    return quantities_of(evidence_of(levels, **given))[0]


def same(sizes, paths=400):
    """Return errors that are the same on all paths, to the digits that are kept."""
    return [np.full(paths, size) for size in sizes]


class TestReference:
    """The bound of a slope's bias due to the error of its reference."""

    def test_an_exact_truth_has_none(self):
        """It knows the limit, so that the true slope may be above the estimate by no more than 0."""
        problem = gbm()
        bias = path_order.reference_bias(problem.pathwise, quantity_of(errors(1.0)), FINEST, 0.99)

        assert bias == (0.0, "exact solution", True)
        assert bias.above == 0.0

    def test_a_scheme_of_its_own_has_one_that_says_nothing_about_the_limit(self):
        """Of the order of coherent errors, which is taken as 1/2 at least."""
        orders, halvings = (1.0, 0.5, 0.1), np.array([6.0, 5.0, 4.0, 3.0])
        found = [path_order.reference_bias(None, quantity_of(errors(order)), FINEST, 0.99) for order in orders]

        shares = [2.0 ** (-halvings * max(order, 0.5)) for order in orders]
        expected = [abs(np.array([0.3, 0.1, -0.1, -0.3]) @ np.log2(1.0 - share)) for share in shares]
        assert [each.bound for each in found] == pytest.approx(expected, abs=2e-4)
        assert not any(each.knows_limit or each.above for each in found)
        assert found[0].reference == "own reference 3 levels finer"

    @pytest.mark.parametrize("order", [0.5, 1.5])
    def test_a_truth_of_an_order_has_a_part_of_what_half_its_resolution_changes(self, order):
        """The change of the slope over 2^q - 1: errors h become h + b, far from the scheme's."""
        truth = replace(gbm().pathwise, order=order)
        bias = path_order.reference_bias(truth, quantity_of(same(H), blurred=np.full(400, -0.02)), FINEST, 0.99)

        change = np.array([0.3, 0.1, -0.1, -0.3]) @ np.log2(1.0 + 0.02 / H[2:])
        assert bias.bound == pytest.approx(abs(change) / (2.0**order - 1.0), rel=1e-3)
        assert bias.above == bias.bound
        assert bias.reference == f"reference of order {order} one level finer"

    def test_a_truth_that_nearly_makes_the_finest_steps_is_known_by_them(self):
        """Its error is a part of its distance from them, at half and at full resolution."""
        truth, finest = replace(gbm().pathwise, order=1.5), H[-1] ** 2
        quantity = quantity_of(same(H**2), blurred=np.full(400, 1.05 * finest))
        bias = path_order.reference_bias(truth, quantity, FINEST, 0.99)

        shares = (0.05 + 1.0) * finest / H[2:] ** 2 / (2.0**1.5 - 1.0)
        assert bias.bound == pytest.approx(np.array([0.3, 0.1, 0.1, 0.3]) @ -np.log2(1.0 - shares), rel=1e-3)


class TestCoarseSteps:
    """A component that the finest steps do not resolve."""

    @pytest.mark.parametrize(("moved", "coarse"), [(3.9, True), (4.1, False)])
    def test_an_error_of_a_quarter_of_the_motion_is_large(self, moved, coarse):
        """If halving the step still changes it by half."""
        evidence = evidence_of(same(2.0 ** np.arange(5.0, -1.0, -1.0)), moved=moved)

        assert bool(path_order.why_coarse(evidence, 5)) is coarse

    @pytest.mark.parametrize(("change", "coarse"), [(0.42, True), (0.41, False)])
    def test_a_change_of_an_order_of_one_half_is_that_of_errors_that_fall(self, change, coarse):
        """Of 2^(1/2) - 1 of the error; changes that do not rise count as such alone."""
        evidence = evidence_of(same(0.8 * (1.0 + change * np.arange(5.0, -1.0, -1.0))), moved=1.6)

        found = path_order.why_coarse(evidence, 5)

        assert bool(found) is coarse
        assert not coarse or found.startswith("the error of x is 50% of the solution's displacement at h = 0.00391")

    @pytest.mark.parametrize(("first", "coarse"), [(0.1, True), (0.3, False)])
    def test_changes_that_rise_are_those_of_a_solution_that_comes_up(self, first, coarse):
        """The last change is compared with the one before."""
        sizes = [3.0, 2.6, 2.4, 1.2 + first, 1.2, 1.0]

        assert bool(path_order.why_coarse(evidence_of(same(sizes)), 5)) is coarse

    def test_errors_that_grow_are_not_those_of_coarse_steps(self):
        """Even if changes rise."""
        assert path_order.why_coarse(evidence_of(same([0.5, 0.5, 0.5, 0.5, 0.6, 0.8])), 5) == ""

    @pytest.mark.parametrize(("floor", "on_its_way"), [(0.79, True), (0.81, False)])
    def test_an_order_is_on_its_way_if_its_next_value_reaches_the_claim(self, floor, on_its_way):
        """Local orders 0.4 and 0.6 continue with 0.8."""
        levels = same(2.0 ** -np.cumsum([0.0, 0.1, 0.2, 0.3, 0.4, 0.6]))
        claim = replace(ONE, value=1.0, margin=1.0 - floor)

        found = path_order.why_on_its_way(quantity_of(levels), FINEST, claim)

        assert bool(found) is on_its_way
        assert not on_its_way or "to 0.80 at the next step size" in found

    @pytest.mark.parametrize(("rise", "on_its_way"), [(0.06, True), (0.04, False)])
    def test_an_order_that_rises_by_little_is_not_on_its_way(self, rise, on_its_way):
        """From 0.05 a level on; a claim without an order has no way to it."""
        levels = quantity_of(same(2.0 ** -np.cumsum([0.0, 0.8, 0.8, 0.8, 0.8, 0.8 + rise])))

        assert bool(path_order.why_on_its_way(levels, FINEST, ONE)) is on_its_way
        assert path_order.why_on_its_way(levels, FINEST, replace(ONE, value="round-off")) == ""


class TestExactness:
    """Errors that are rounding."""

    @staticmethod
    def rounding(steps=SETTINGS.steps[-1]):
        """Return eps sqrt(N) for a solution of size 1."""
        return EPS * np.sqrt(steps)

    @pytest.mark.parametrize(("times", "exact"), [(60.0, True), (70.0, False)])
    def test_errors_of_64_operations_are_rounding(self, times, exact):
        """At every level, each with its number of steps."""
        sizes = times * EPS * np.sqrt(SETTINGS.steps)

        found = path_order.judge_exact(*pair(same(sizes)))

        assert (found is not None) is exact
        assert not exact or (found.verdict, str(found.reason)) == (
            Verdict.VERIFIED,
            "exact to round-off at all 6 step sizes",
        )

    @pytest.mark.parametrize("bad", ["failed", "truncated"])
    def test_runs_that_go_wrong_are_not_exact(self, bad):
        """Nor is a scheme that is its own reference, unless one step is exact."""
        zeros = same(np.zeros(6))

        assert path_order.judge_exact(*pair(zeros, health_of=health(**{bad: [0, 0, 0, 0, 0, 1]}))) is None
        assert path_order.judge_exact(*pair(zeros, problem=blind())) is None
        assert path_order.judge_exact(*pair(zeros, problem=blind()), confirmed=True).verdict is Verdict.VERIFIED

    @pytest.mark.parametrize(("times", "verdict"), [(0.9, Verdict.INCONCLUSIVE), (1.1, Verdict.VERIFIED)])
    def test_a_solution_has_to_move_by_a_thousand_roundings(self, times, verdict):
        """Of a solution of size 1."""
        evidence, quantity = pair(same(np.zeros(6)))
        moves = replace(quantity, moved=times * 64e3 * self.rounding())

        assert path_order.judge_exact(evidence, moves).verdict is verdict


def pair(levels, **given):
    """Return evidence, and its quantity x."""
    evidence = evidence_of(levels, **given)
    return evidence, quantities_of(evidence)[0]


class TestUsableLevels:
    """Levels to which a slope can be fitted."""

    @pytest.mark.parametrize(("times", "count"), [(59.0, 5), (61.0, 6)])
    def test_errors_below_60_roundings_are_left_out(self, times, count):
        """At the level where they are so small."""
        sizes = np.append(H[:5], times * EPS * np.sqrt(SETTINGS.steps[-1]))

        levels, why = path_order.usable_levels(*pair(same(sizes)))

        assert len(levels) == count
        assert ("round-off at 1 step size" in str(why)) is (count == 5)

    @pytest.mark.parametrize(("fastest", "first"), [(0.99, 3), (1.01, 2)])
    def test_steps_longer_than_the_fastest_time_are_left_out(self, fastest, first):
        """Steps as long as it are not."""
        problem = replace(gbm(), fastest_time=fastest * H[2])

        levels, why = path_order.usable_levels(*pair(errors(1.0), problem=problem))

        assert levels.tolist() == list(range(first, 6))
        assert "steps longer than the fastest time" in str(why)

    @pytest.mark.parametrize("count", [0, 3])
    def test_truncated_steps_are_usable_on_request(self, count):
        """They are told where there are any."""
        evidence, quantity = pair(errors(1.0), health_of=health(truncated=[count, 0, 0, 0, 0, 0]))

        strict, _ = path_order.usable_levels(evidence, quantity)
        every, why = path_order.usable_levels(evidence, quantity, truncated=True)

        assert (len(strict), len(every)) == (6 if count == 0 else 5, 6)
        assert str(why) == ("truncated steps at 1 step size" if count else "")


class TestFits:
    """Slopes, the order in the limit, and whether errors may still begin to fall."""

    def test_a_slope_is_that_of_the_four_finest_levels(self):
        """And a bias widens its interval on both sides."""
        sizes = np.concatenate([H[:2] * 5.0, H[2:] ** 1.5])
        evidence, quantity = pair(same(sizes))

        fitted = path_order.fit(evidence, quantity, ALL, None, path_order.Bias(0.1, "reference", True))

        assert fitted.levels.tolist() == [2, 3, 4, 5]
        assert fitted.slope.value == pytest.approx(1.5, abs=1e-4)
        assert fitted.interval == pytest.approx((1.4, 1.6), abs=1e-3)

    def test_the_order_in_the_limit_needs_five_levels(self):
        """Its interval is no narrower than 0.05, and has the change by the coarsest level."""
        evidence, quantity = pair(same(H**1.5))
        four, five, six = (path_order.fit(evidence, quantity, ALL[first:], None) for first in (2, 1, 0))
        bent = path_order.fit(*pair(same(np.append(3.0 * H[0], H[1:]))), ALL, None)

        assert np.isnan(path_order.asymptotic_order(four)).all()
        assert path_order.asymptotic_order(five) == pytest.approx((1.5, 0.05), abs=1e-3)
        assert path_order.asymptotic_order(six) == pytest.approx((1.5, 0.05), abs=1e-3)
        value, half = path_order.asymptotic_order(bent)
        assert value == pytest.approx(1.0, abs=1e-3)
        assert half == pytest.approx(abs(bent.quantity.corrected_slope(ALL).value - 1.0), rel=1e-2)

    @pytest.mark.parametrize(("limit", "early"), [(0.0, True), (0.02, False)])
    def test_errors_that_fall_like_their_differences_at_the_finest_levels_are_early(self, limit, early):
        """Those towards a wrong limit level off further; three levels do not show it."""
        quantity = quantity_of(same(H + limit))

        assert path_order.seems_early(quantity, FINEST, 0.0) is early
        assert not path_order.seems_early(quantity, FINEST[1:], 0.0)

    def test_a_contrast_that_rises_is_early(self):
        """Errors a h + b h^2 bend less and less."""
        bent = quantity_of(same(H + 6.0 * H**2))

        assert bent.contrast(FINEST[-3:]).p_below(path_order.WRONG_LIMIT) < 0.01
        assert path_order.seems_early(bent, FINEST, 0.0)

    def test_an_interval_above_the_claim_is_no_wrong_limit_yet(self):
        """It is too high for one, however errors level off."""
        above = path_order.fit(*pair(same(2.0 * H**1.5)), ALL, None)
        below = path_order.fit(*pair(same(2.0 * H**0.9)), ALL, None)

        assert path_order.is_above(above, ONE)
        assert not path_order.is_above(below, ONE)
        assert not path_order.is_above(above, replace(ONE, value="round-off"))

    def test_a_lower_term_is_sought_on_five_levels(self):
        """Those of the slope, and one coarser."""
        evidence, quantity = pair(same(H * (1.0 + 3.0 * H)))
        fitted = path_order.fit(evidence, quantity, ALL, None)

        found = path_order.lower_share(fitted, ONE.value)

        assert found == (quantity.lower_share(ALL[1:], 1.0), 0.0)

    @pytest.mark.parametrize("heavy", [2, 5, None])
    def test_heavy_tails_at_one_end_weaken_small_samples(self, heavy):
        """They refute nothing then."""
        levels = errors(1.0, paths=400)
        if heavy is not None:
            levels[heavy] = np.append(levels[heavy][1:], np.abs(levels[heavy]).sum())
        fitted = path_order.fit(*pair(levels), ALL, None)

        assert (fitted.calibrate(PathTests(1.0, 1e-9, Reason(""))).refuted == 1.0) is (heavy is not None)

    def test_a_reference_of_the_scheme_itself_shows_no_wrong_limit(self):
        """The hypothesis of one is never rejected."""
        own, exact = (path_order.fit(*pair(same(H), problem=problem), ALL, None) for problem in (blind(), None))

        assert own.p_wrong_limit == 1.0
        assert exact.p_wrong_limit < 0.01


class TestTests:
    """The tests of a claim by errors along paths."""

    @staticmethod
    def of_errors(sizes, value=1.0, **given):
        """Return the tests of errors that are nearly the same on all paths."""
        rng = np.random.default_rng(3)
        levels = [size * (1.0 + 1e-3 * rng.normal(size=4000)) for size in sizes]
        return path_order.path_tests(path_order.fit(*pair(levels, **given), ALL, None), replace(ONE, value=value))

    def test_a_low_order_that_rises_is_open(self):
        """One that is as claimed may rise, and a claim of exactness is refuted by any."""
        rising = 2.0 ** -np.cumsum([0.0, 0.9, 0.9, 1.0, 1.1, 1.25])
        low, right = self.of_errors(H / (1.0 + 60.0 * H)), self.of_errors(rising)
        exact = self.of_errors(rising, value="round-off")

        assert "the order still rises: take finer steps" in str(low.reason)
        assert low.refuted == 1.0
        assert "take finer steps" not in str(right.reason) + str(exact.reason)
        assert right.verified < 0.01
        assert exact.refuted < 0.01

    def test_errors_that_fall_faster_than_claimed_show_no_wrong_limit(self):
        """Although they level off more and more."""
        assert self.of_errors(H**2 + 1e-5).limit == 1.0
        assert self.of_errors(H + 1e-2).limit < 1e-6

    @pytest.mark.parametrize(("order", "decides"), [(1.5, True), (1.4, False)])
    def test_a_truth_has_to_be_better_than_the_claim_by_half_an_order(self, order, decides):
        """Else nothing is tested."""
        problem = replace(gbm(), truths=(replace(gbm().pathwise, order=order),))
        found = self.of_errors(H, problem=problem, blurred=np.zeros(4000))

        assert ("needs an order of at least 1.5" in str(found.reason)) is not decides


class TestWrongLimits:
    """The tests of an order with those of its limit."""

    SLOW = Estimate(-0.1, 0.02)
    WRONG = SLOW.p_below(path_order.WRONG_LIMIT)

    def limited(self, level, *, contrast=SLOW, refuted=0.4, early=False):
        """Return the tests of a verified order whose errors fall more slowly than their differences."""
        fitted = SimpleNamespace(
            evidence=SimpleNamespace(level=level, settings=SETTINGS),
            bias=path_order.Bias(0.0, "", True),
            quantity=SimpleNamespace(contrast=lambda levels: contrast),
            levels=FINEST,
            p_wrong_limit=1.0,
        )
        return path_order.with_limit(PathTests(1e-9, refuted, Reason("figures")), fitted, early=early)

    @pytest.mark.parametrize(("part", "wrong"), [(1.01, True), (0.99, False)])
    def test_a_wrong_limit_has_half_of_the_level(self, part, wrong):
        """It is one of two tests; early levels are held back by it, and others refuted."""
        late, early = (self.limited(2.0 * part * self.WRONG, early=each) for each in (False, True))

        assert late.reason.has(Kind.WRONG_LIMIT) is wrong
        assert late.refuted == late.limit == pytest.approx(2.0 * self.WRONG)
        assert (early.refuted, early.limit) == (1.0 if wrong else 0.8, 1.0)
        assert ("take finer steps" in str(early.reason)) is wrong
        assert early.suspected == pytest.approx(2.0 * self.WRONG if wrong else 1.0)
        assert early.verified == late.verified == 1.0

    def test_the_smaller_p_value_of_order_and_limit_counts_twice(self):
        """And is at most 1."""
        assert self.limited(1e-9, refuted=0.2 * self.WRONG).refuted == pytest.approx(0.4 * self.WRONG)
        right = self.limited(1e-9, contrast=Estimate(0.0, 0.02), refuted=0.9)
        assert (right.limit, right.refuted) == (1.0, 1.0)

    def test_a_limit_that_is_not_shown_leaves_a_verified_order_open(self):
        """The tests are as sure as the less sure of both."""
        found = self.limited(1e-3)

        assert found.verified == 1.0
        assert "errors may level off, p = 1 exceeds the level of the run" in str(found.reason)


class TestRows:
    """The rows of the levels, and what is read of a tally."""

    def test_a_level_has_its_mean_error_with_the_standard_error(self):
        """And further norms, the order from the level before, and whether a slope is fitted to it."""
        sizes = np.abs(np.random.default_rng(4).normal(size=400))
        quantity = quantity_of([size * sizes for size in H])

        rows = list(level_rows(quantity, {4, 5}, {"L_half": 0, "L2": 2}))

        last = rows[5]
        assert (last.quantity, last.level) == ("x", 5)
        assert last.estimate == pytest.approx(H[5] * sizes.mean(), rel=1e-4)
        assert last.std_error == pytest.approx(H[5] * sizes.std() / 20.0, rel=1e-3)
        assert last.details["estimate_L_half"] == pytest.approx(H[5] * np.mean(sizes**0.5) ** 2, rel=1e-3)
        assert last.details["estimate_L2"] == pytest.approx(H[5] * np.mean(sizes**2) ** 0.5, rel=1e-3)
        assert last.details["local_order"] == pytest.approx(1.0, abs=1e-3)
        assert [row.details["fitted"] for row in rows] == [False] * 4 + [True] * 2

    def test_a_level_without_an_error_before_it_has_no_order(self):
        """The coarsest one, and those beside an error of 0."""
        rows = list(level_rows(quantity_of(same([0.5, 0.25, 0.0, 0.1, 0.05, 0.02])), (), {}))

        unknown = [np.isnan(row.details["local_order"]) for row in rows]
        assert unknown == [True, False, True, True, False, False]

    def test_the_rise_of_a_contrast_is_that_of_two_pairs_of_levels(self):
        """Of the local orders of errors less those of their differences."""
        sizes = H * (1.0 + 6.0 * H)
        orders = [np.log2(values[:-1] / values[1:]) for values in (sizes, sizes[:-1] - sizes[1:])]
        contrast = orders[0][-2:] - orders[1][-2:]

        found = quantity_of(same(sizes)).contrast_rise(FINEST)

        assert found.value == pytest.approx(contrast[1] - contrast[0], abs=1e-3)

    def test_errors_of_another_kind_are_read_by_its_name(self):
        """They have no differences."""
        evidence = evidence_of(errors(1.0))
        other = tally_errors("grid", {"x": np.abs(errors(0.5))})
        tally = replace(evidence.tally, sums={**evidence.tally.sums, **other.sums})
        tally = replace(tally, largest={**tally.largest, **other.largest})

        (quantity,) = quantities_of(replace(evidence, tally=tally), "grid")

        assert (quantity.name, quantity.powers, quantity.difference.size) == ("x", 4, 0)
        assert quantity.slope(FINEST).value == pytest.approx(0.5, abs=1e-3)
        assert quantity.means(3)[5] == pytest.approx(np.mean(errors(0.5)[5] ** 4), rel=1e-3)
