"""Findings on strong order from an order of one step and errors along paths, both made by hand."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from cells import claimant
from conformance.test_run_memory import AdamsBashforth
from facade import (
    ErrorObserver,
    EulerMaruyama,
    KeptAlgebraic,
    StochasticTheta,
    delay_test,
    double_well,
    gbm,
    member_findings,
    quantities_of,
    step_findings,
    strong_findings,
)
from measures.test_path_errors import ONE, SETTINGS, H, blind, errors, evidence_of, health, same
from probe import strong_cells
from sdaeverify import Step
from sdaeverify.measuring import Evidence, Snapshot, Tally, Verdict
from verdicts.test_limits_of_rules import STEP

RIGHT, WRONG, OPEN = Verdict.VERIFIED, Verdict.REFUTED, Verdict.INCONCLUSIVE
NOTHING = np.zeros(6)
LOW = STEP._replace(order=0.5, ahead=0.5, typical=0.5)
UNKNOWN = STEP._replace(compared=False)


def found(levels, order, **given):
    """Return the finding on x from errors of each level and the order of one step."""
    evidence = evidence_of(levels, **given)
    return strong_findings.judge_errors(evidence, quantities_of(evidence)[0], "strong", order).finding


class TestExact:
    """Errors that are rounding, and the order of one step."""

    @pytest.mark.parametrize(
        ("order", "verdict", "tier"),
        [(None, RIGHT, 3), (UNKNOWN, RIGHT, 3), (STEP, RIGHT, 1), (LOW, WRONG, 1)],
    )
    def test_one_step_decides_if_it_does(self, order, verdict, tier):
        """Else errors that are rounding do."""
        finding = found(same(NOTHING), order)

        assert (finding.verdict, finding.tier) == (verdict, tier)
        assert "exact to round-off at all 6 step sizes" in str(finding.reason)

    def test_without_a_claim_it_is_out_of_scope(self):
        """Errors are rounding all the same."""
        assert found(same(NOTHING), None, claims=()).verdict is Verdict.OUT_OF_SCOPE

    @pytest.mark.parametrize(
        ("order", "verdict"),
        [
            (STEP._replace(order=inf, ahead=inf), RIGHT),
            (STEP, OPEN),
            (STEP._replace(order=inf, ahead=inf, compared=False), OPEN),
            (None, OPEN),
        ],
    )
    def test_a_reference_of_the_scheme_itself_needs_an_exact_step(self, order, verdict):
        """One that follows the equation; else a scheme that never moves agrees with itself."""
        assert found(same(NOTHING), order, problem=blind()).verdict is verdict


class TestSlopes:
    """Slopes of errors, alone and as a guard of one step."""

    @pytest.mark.parametrize(("order", "verdict"), [(None, OPEN), (STEP, RIGHT)])
    def test_a_lower_term_leaves_the_order_of_paths_alone_open(self, order, verdict):
        """Of a quarter of the finest error; one step shows that there is none."""
        finding = found(same(H + 0.02 * H**0.5), order)

        assert finding.verdict is verdict
        assert np.isfinite(finding.order_resolution) is np.bool_(order is None)

    def test_a_claim_of_exactness_is_refuted_by_errors(self):
        """Whatever their order."""
        exact = replace(ONE, value="round-off")

        assert found(errors(1.0), None, claims=(exact,)).verdict is WRONG

    @pytest.mark.parametrize(
        ("sizes", "verdict"),
        [
            (H**0.5, WRONG),
            (np.append(3.0 * H[0] ** 0.75, H[1:] ** 0.75), OPEN),
            (np.append(1.02 * H[0] ** 0.72, H[1:] ** 0.72), WRONG),
        ],
        ids=["a low order", "one whose limit may reach the claim", "one whose limit does not"],
    )
    def test_a_low_slope_refutes_one_step_if_its_limit_is_low_too(self, sizes, verdict):
        """The upper end of the interval of the order in the limit is compared with the claim."""
        finding = found(same(sizes), STEP)

        assert finding.verdict is verdict
        assert finding.high < 0.8

    @pytest.mark.parametrize("heavy", [2, 5])
    def test_tails_count_at_both_ends_of_the_fit(self, heavy):
        """One path with half of the error."""
        levels = errors(1.0, paths=400)
        levels[heavy] = np.append(levels[heavy][1:], np.abs(levels[heavy]).sum())

        assert found(levels, None).details["heavy_tails"]
        assert not found(errors(1.0, paths=400), None).details["heavy_tails"]

    @pytest.mark.parametrize(
        ("order", "consistent"),
        [(STEP, True), (UNKNOWN, False), (STEP._replace(departure="off"), False)],
    )
    def test_a_step_is_consistent_if_it_was_compared_and_follows(self, order, consistent):
        """As the details say; without an order they are silent."""
        assert found(errors(1.0), order).details["local_consistent"] is consistent
        assert "local_consistent" not in found(errors(1.0), None).details


class TestWithoutASlope:
    """Too few levels for a slope."""

    FEW = health(truncated=[1, 1, 1, 1, 0, 0])
    LOST = health(failed=[1] * 6, lost=[1] * 6)

    @pytest.mark.parametrize(
        ("order", "given", "verdict"),
        [
            (LOW, {}, WRONG),
            (STEP, {}, OPEN),
            (None, {}, OPEN),
            (LOW, {"claims": ()}, Verdict.OUT_OF_SCOPE),
            (LOW, {"health_of": LOST}, Verdict.DIVERGED),
        ],
    )
    def test_one_step_refutes_and_verifies_nothing(self, order, given, verdict):
        """Paths that are lost are told first."""
        finding = found(errors(1.0), order, **{"health_of": self.FEW, **given})

        assert finding.verdict is verdict
        assert (", but along paths fewer than 3 step sizes" in str(finding.reason)) is (
            order is STEP and verdict is OPEN
        )


class TestUnknownComponents:
    """Components that the truth lacks."""

    @pytest.mark.parametrize(("order", "verdict"), [(LOW, WRONG), (STEP, OPEN)])
    def test_one_step_may_refute_their_order(self, order, verdict):
        """No path guards a verified one."""
        settings = replace(SETTINGS, paths=400)
        observer = ErrorObserver({"other": np.zeros((1, 400))}, settings)
        truth = {"other": np.ones((1, 400))}
        observer.after_coarsest_step(Snapshot([truth] * 6, truth, None))
        evidence = Evidence(claimant(ONE), gbm(), gbm(), settings, observer.tally(), health())

        (finding,) = strong_findings.unknown_findings(evidence, "strong", {"x": order})

        assert (finding.quantity, finding.verdict) == ("x", verdict)


class TestMembers:
    """Random members of a form, on which one step is probed near the start."""

    def test_steps_without_memory_have_an_order(self):
        """Of each component, and of the state; other values than orders are no matter of one step."""
        found = list(member_findings(EulerMaruyama(), double_well(), "strong"))

        assert [(each.quantity, each.verdict) for each in found] == [("x", RIGHT), ("state", RIGHT)]

        class Exact(EulerMaruyama):
            claims = (replace(ONE, value="round-off"),)

        assert list(member_findings(Exact(), double_well(), "strong")) == []

    def test_a_step_on_a_problem_has_the_order_of_all_its_states(self):
        """Of what is claimed as an order."""

        class Silent(EulerMaruyama):
            claims = ()

        found = list(step_findings(EulerMaruyama(), gbm(), gbm(), "strong"))

        assert [(each.quantity, each.verdict) for each in found] == [("x", RIGHT), ("state", RIGHT)]
        assert [each.estimate for each in found] == pytest.approx([0.5, 0.5], abs=0.01)
        assert list(step_findings(Silent(), gbm(), gbm(), "strong")) == []

    def test_what_cannot_be_probed_is_open(self):
        """A memory, as a member has no history, and steps that fail."""

        class Failing(EulerMaruyama):
            def step(self, problem, state, t, h, noise):
                return Step(state + noise.dW, failed=np.ones(state.shape[1], dtype=bool))

        for scheme, why in (
            (AdamsBashforth(), "a random member has no history"),
            (Failing(), "steps of every size fail"),
        ):
            (finding,) = member_findings(scheme, double_well(), "strong")
            assert (finding.quantity, finding.verdict) == ("state", OPEN)
            assert why in str(finding.reason)


class TestProbes:
    """What is probed of one step, and read again."""

    def test_steps_without_an_order_are_probed_at_the_shortest_sizes(self):
        """Right schemes have one at the first sizes, a step that is off by sqrt(h) has none."""
        wrong = strong_cells.Formula(lambda p, x, h, n: strong_cells.euler(p, x, h, n) + np.sqrt(h))
        right, other = (strong_findings.probe_strong(each, gbm(), SETTINGS) for each in (EulerMaruyama(), wrong))

        assert not named(right, "at the shortest steps")
        assert named(other, "at the shortest steps")

    @pytest.mark.sweep
    @pytest.mark.parametrize(
        ("scheme", "problem", "span", "probed"),
        [
            (StochasticTheta(), delay_test(horizon=3.3), strong_findings.WHOLE, True),
            (StochasticTheta(), delay_test(horizon=3.3), strong_findings.FIRST, False),
            (StochasticTheta(), delay_test(), strong_findings.WHOLE, False),
            (KeptAlgebraic(), delay_test(horizon=3.3), strong_findings.WHOLE, False),
        ],
    )
    def test_defects_of_y_are_those_of_a_delay_between_mesh_points(self, scheme, problem, span, probed):
        """After the first delay, of a scheme that solves for y."""
        assert bool(named(strong_findings.probe_strong(scheme, problem, SETTINGS, span), "of y")) is probed

    def test_memory_bounds_the_order(self):
        """An order that memory leaves is that of each component and of the state; without memory it is infinite."""
        for scheme, problem, remembers in ((EulerMaruyama(), gbm(), False), (AdamsBashforth(), double_well(), True)):
            orders = read(scheme, problem)
            assert [*orders] == ["x", "state"]
            assert [np.isfinite(order.memory) for order in orders.values()] == [remembers] * 2

    @pytest.mark.sweep
    @pytest.mark.parametrize("own", [0.3, 0.7, None])
    def test_the_order_of_y_is_the_smaller_one_of_x_and_of_its_own(self, monkeypatch, own):
        """Which is known between mesh points; that of x is 1/2."""
        monkeypatch.setattr(strong_findings, "algebraic_order", lambda record: own)
        orders = read(StochasticTheta(), delay_test(horizon=4.0 if own is None else 3.3))
        expected = 0.5 if own is None else min(own, 0.5)

        assert [orders[name].order for name in ("x", "y", "state")] == pytest.approx(
            [0.5, expected, expected], abs=0.03
        )

    def test_nothing_is_read_where_nothing_was_probed(self):
        """There is no order then."""
        assert strong_findings.local_orders(Evidence.of_one_step(EulerMaruyama(), gbm())) == {}


def named(tally, part):
    """Return the names of a tally that contain a text."""
    return [name for name in tally.sums if part in name]


def read(scheme, problem):
    """Return the local orders of a scheme that was probed."""
    tally = strong_findings.probe_strong(scheme, problem, SETTINGS)
    return strong_findings.local_orders(Evidence(scheme, problem, problem, SETTINGS, tally, Tally()))
