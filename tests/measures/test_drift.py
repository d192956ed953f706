"""Classes and verdicts of constraint drift from residuals that are prescribed."""

from typing import ClassVar

import numpy as np
import pytest

from facade import (
    EDGES,
    SAMPLED,
    Drift,
    EulerMaruyama,
    ResidualObserver,
    StochasticTheta,
    _classify,
    gbm,
    gbm_algebraic,
    log_spaced,
    quadrature,
    quantile,
)
from sdaeverify import Claim, HolonomicSDAE, Residual, Scheme, Settings, verify
from sdaeverify.measuring import Evidence, Tally, Verdict

SETTINGS = Settings(paths=400, block=400)
SIZES = np.abs(np.random.default_rng(8).normal(size=400)) + 0.5


class Prescribed:
    """A problem whose only residual is what the parts say."""

    horizon = 1.0
    fastest_time = np.inf
    pathwise = None
    traits = frozenset()

    def equation(self):
        """Return that no Ito equation is known."""

    def residuals(self, parts):
        return {"g": Residual(parts["g"][None], np.ones_like(parts["g"]))}


def scheme_with(value, margin):
    claim = Claim(measure="drift", value=value, margin=margin, source="test")

    class Claimant(Scheme):
        """A scheme that claims something about drift and is never run."""

        name: ClassVar[str] = "claimant"
        form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
        claims: ClassVar[tuple[Claim, ...]] = (claim,)

    return Claimant()


def judge(residual, value="round-off", failed=0, margin=0.2):
    """Return the finding and the levels of a residual given as a function of h and t."""
    problem = Prescribed()
    observer = ResidualObserver(problem, {"g": np.zeros(400)}, SETTINGS)
    for level, steps in enumerate(SETTINGS.steps):
        for step in sorted(observer.wanted[level]):
            observer.after_step(level, step, {"g": SIZES * residual(1.0 / steps, step / steps)})
    zeros = np.zeros(SETTINGS.levels)
    health = {"failed": zeros + failed, "lost": zeros, "truncated": zeros, "steps": zeros + 1}
    evidence = Evidence(scheme_with(value, margin), problem, problem, SETTINGS, observer.tally(), Tally(sums=health))
    (finding,), levels = Drift().judge(evidence)
    return finding, levels


def test_rounding_is_round_off():
    """A few eps at every h keep the claim of an exact constraint."""
    finding, _ = judge(lambda h, t: 1e-16)

    assert finding.verdict is Verdict.VERIFIED
    assert finding.details["class"] == "round-off"


def test_round_off_keeps_a_claim_of_any_order():
    """An exact constraint verifies a claimed order of its residual."""
    finding, _ = judge(lambda h, t: 1e-16, value=1.0)

    assert finding.verdict is Verdict.VERIFIED


def test_tolerance_refutes_round_off():
    """A residual at a solver's tolerance is told as such and refutes a claim of round-off."""
    finding, _ = judge(lambda h, t: 1e-7)

    assert finding.verdict is Verdict.REFUTED
    assert finding.details["class"] == "tolerance-limited"


@pytest.mark.parametrize("growth", [0.5, 1.5])
def test_order_and_growth_are_found(growth):
    """A residual h t^q has order 1 and growth exponent q."""
    finding, _ = judge(lambda h, t: h * t**growth, value=1.0)

    assert finding.verdict is Verdict.VERIFIED
    assert finding.estimate == pytest.approx(1.0, abs=2.0**-SAMPLED)
    assert finding.details["growth"] == pytest.approx(growth, abs=2.0**-SAMPLED)


def test_lower_order_is_refuted():
    """A residual of order 1/2 refutes a claim of 1."""
    finding, _ = judge(lambda h, t: np.sqrt(h) * t, value=1.0)

    assert finding.verdict is Verdict.REFUTED


# Local orders of balanced Euler on constrained-curve[shape=space,sigma=0.296,theta_0=0.219,horizon=1.85].
SLOW = np.cumsum([0.0, -0.034, 0.026, 0.118, 0.173, 0.226])


def slowly(h, floor=0.0):
    return 0.02 * (2.0 ** -SLOW[int(np.log2(1.0 / h)) - 3] + floor)


def test_orders_that_rise_slowly_refute_nothing():
    """Local orders of 0.03 to 0.23, which tend to 1/2 on finer steps, are not held against a claim of 1/2."""
    finding, _ = judge(lambda h, t: slowly(h), value=0.5, margin=0.3)

    assert finding.estimate == pytest.approx(0.18, abs=0.01)
    assert finding.verdict is Verdict.INCONCLUSIVE
    assert "as h tends to 0" in str(finding.reason)


def test_a_part_that_stays_is_refuted_on_the_same_steps():
    """The same residual beside one that does not fall with h is refuted."""
    finding, _ = judge(lambda h, t: slowly(h, floor=2.0), value=0.5, margin=0.3)

    assert finding.verdict is Verdict.REFUTED


def test_steps_longer_than_the_fastest_time_refute_nothing(monkeypatch):
    """A residual of order 1/2 is not held against a claim of 1 where no step resolves it, nor asks for paths."""
    monkeypatch.setattr(Prescribed, "fastest_time", 1e-3)
    finding, _ = judge(lambda h, t: np.sqrt(h) * t, value=1.0)

    assert (finding.verdict, finding.settled) == (Verdict.INCONCLUSIVE, True)
    assert "does not resolve the fastest time" in str(finding.reason)


def test_accumulation_is_flagged():
    """A residual that grows as h tends to 0 is named."""
    finding, _ = judge(lambda h, t: 1e-12 / h)

    assert finding.details["class"] == "growing as h tends to 0"
    assert finding.verdict is Verdict.REFUTED


def test_steps_without_root_leave_round_off_undecided():
    """A constraint that holds only because steps were not made verifies nothing."""
    finding, _ = judge(lambda h, t: 1e-16, failed=2)

    assert finding.verdict is Verdict.INCONCLUSIVE
    assert "failed paths" in str(finding.reason)


def test_residuals_beside_paths_without_root_refute_nothing():
    """Near a double root Newton's update tells less of the residual; where all paths have roots, it refutes."""
    rootless = np.arange(SETTINGS.levels) < 2
    near = 0.75 * (SETTINGS.steps[1] ** -1.0 + SETTINGS.steps[2] ** -1.0) / 1.5

    held, _ = judge(lambda h, t: 5e-12 if h > near else 1e-16, failed=rootless)
    wrong, _ = judge(lambda h, t: 5e-12, failed=rootless)

    assert held.verdict is Verdict.INCONCLUSIVE
    assert "no root" in str(held.reason)
    assert wrong.verdict is Verdict.REFUTED


def test_levels_hold_the_supremum_and_quantiles():
    """Each level reports sup RMS, maximum and quantiles of the largest residual of a path."""
    _, levels = judge(lambda h, t: h * t, value=1.0)

    coarsest = levels[0]
    h = 1.0 / SETTINGS.steps[0]
    bin_width = 2.0 ** (0.5 * (EDGES[1] - EDGES[0]))
    assert coarsest.estimate == pytest.approx(h * np.sqrt((SIZES**2).mean()), rel=1e-3)
    assert coarsest.details["max"] == pytest.approx(h * SIZES.max(), rel=1e-12)
    assert 1 / bin_width <= coarsest.details["median"] / (h * np.median(SIZES)) <= bin_width * 1.01


def test_log_spaced_steps_are_distinct_and_end_at_the_last():
    """At most 64 different steps, the first and the last among them."""
    for steps in (1, 8, 100, 4096):
        times = log_spaced(steps)
        assert times[0] == 1
        assert times[-1] == steps
        assert len(set(times)) == len(times) <= 64


def test_quantile_of_an_empty_histogram_is_not_a_number():
    """Without finite residuals there is no quantile."""
    assert np.isnan(quantile(np.zeros(len(EDGES) - 1), 0.5))


@pytest.mark.parametrize("growth", [0.5, 1.0, 2.0])
def test_levels_hold_the_norm_in_time(growth):
    """The mean over paths of (int g^2 dt)^{1/2} is that of the power of t, to the error of 64 points."""
    _, levels = judge(lambda h, t: t**growth, value=1.0)

    expected = SIZES.mean() / np.sqrt(2.0 * growth + 1.0)
    assert [row.details["l2"] for row in levels[3:]] == pytest.approx([expected] * 3, rel=2e-3)
    assert levels[-1].details["l2_std_error"] == pytest.approx(SIZES.std() / np.sqrt(2 * growth + 1) / 20, rel=0.4)


@pytest.mark.parametrize("steps", [1, 8, 64, 65, 100, 256, 1000, 2**14])
def test_the_quadrature_is_the_trapezoidal_rule(steps):
    """Weights add up to the interval less half the step at its start, where the defect is 0."""
    weights = quadrature(steps)

    assert len(weights) == min(steps, 64)
    assert min(weights) >= 1
    assert max(weights) <= steps
    assert sum(weights.values()) == pytest.approx(1.0 - 0.5 / steps)


@pytest.mark.parametrize("period", [2, 4, 8, 11])
@pytest.mark.parametrize("steps", [256, 1000, 2**14])
def test_a_defect_that_is_reset_is_met_at_all_its_phases(steps, period):
    """A sawtooth in time has its mean square to an eighth, whether or not its period divides the stretches."""
    found = sum(weight * (step % period) ** 2 for step, weight in quadrature(steps).items())

    assert found == pytest.approx((np.arange(period) ** 2).mean(), rel=0.125)


def test_what_is_eliminated_leaves_no_residual() -> None:
    """A scheme that sees an index-1 problem without its algebraic components has no constraint to drift from."""
    problem = gbm_algebraic()

    assert Drift().refuses(StochasticTheta(), problem) == ""
    assert "y eliminated" in Drift().refuses(EulerMaruyama(), problem)
    assert "no constraint" in Drift().refuses(EulerMaruyama(), gbm())


def test_a_state_of_strong_order_keeps_its_constraints_with_that_order():
    """Where one step verifies the order of the whole state, paths on few levels guard that of its residual."""
    found = verify("milstein", "circle", "drift")

    (row,) = found.verdicts.to_dict("records")
    assert (row["verdict"], row["decided_by"]) == ("verified", "T1")
    assert row["guarded_by"] == "the residual along paths"
    assert row["paths"] == 256
    assert len(found.levels) == found.settings.first_levels


def test_the_local_order_of_a_residual_is_that_of_one_step():
    """The local order of a row is the one that verifies it, and the order along paths is another number."""
    (row,) = verify("milstein", "circle", "drift").verdicts.to_dict("records")

    assert row["local_order"] == pytest.approx(1.0, abs=0.01)
    assert row["local_order"] != row["path_order"]


class Modest(EulerMaruyama):
    """Euler-Maruyama that claims its residual has the order of the state."""

    name: ClassVar[str] = "modest"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="drift", value=0.5, margin=0.2, source="test"),)


class Boasting(EulerMaruyama):
    """Euler-Maruyama that claims a residual of order 1, which its state has not."""

    name: ClassVar[str] = "boasting"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="drift", value=1.0, margin=0.2, source="planted"),)


@pytest.mark.parametrize(("scheme", "verdict", "tier"), [(Modest(), "verified", "T1"), (Boasting(), "refuted", "T3")])
def test_where_one_step_does_not_verify_the_state_the_residual_decides(scheme, verdict, tier):
    """A residual may be smaller than the state is off: of a higher order than the state's, paths tell."""
    (row,) = verify(scheme, "circle", "drift").verdicts.to_dict("records")

    assert (row["verdict"], row["decided_by"]) == (verdict, tier)


@pytest.mark.parametrize(
    ("slope", "sup", "kind"),
    [
        (0.99, 1.0, "order 0.99"),
        (-0.5, 1.0, "growing as h tends to 0"),
        (0.0, 1e-6, "tolerance-limited"),
        (0.0, 1.0, "constant"),
    ],
)
def test_a_drift_is_classified_by_its_slope_and_its_size(slope, sup, kind):
    """Each class has its name."""
    assert _classify(slope, sup, 1.0) == kind
