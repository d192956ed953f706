"""A mean claimed to be right within a bound at every step size."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import MALA, BiasSample, FunctionalOrder, log_ratio, ou
from sdaeverify import SDE, Claim, Scheme, Settings, Step, verify
from sdaeverify.measures.invariant.bias import bias_of_chains, bias_of_operator
from sdaeverify.measuring import Evidence, PathTests, Reason, Verdict
from sdaeverify.numerics import GROUPS
from sdaeverify.probing import why_not_operator
from sdaeverify_lab.planted.mechanics import AcceptsAll
from stationary_cells import Shaken, euler_variance

H = 0.25 / 2.0 ** np.arange(4)
TOLD = FunctionalOrder(1.0, 1.0, 1.0)
EVIDENCE = Evidence(MALA(), None, None, Settings(), None, None, level=0.005)


@dataclass(frozen=True)
class Within(AcceptsAll):
    """Euler-Maruyama with a bound of its bias of x^2."""

    bound: float = 0.01

    name: ClassVar[str] = "within"

    @property
    def promises(self):
        """Return the claim."""
        return (Claim(measure="invariant", value="unbiased", bound=self.bound, quantities=("x^2",), source="test"),)


def invariant(scheme, problem="ou", **settings):
    """Return the verdicts on stationary means by quantity."""
    found = verify([scheme], problem, "invariant", **settings).verdicts
    return dict(zip(found["quantity"], found["verdict"], strict=True))


@pytest.mark.parametrize(
    ("errors", "floor", "verdict"),
    [
        ([0.009, -0.004, 0.002, 0.001], 1e-6, Verdict.VERIFIED),
        ([0.011, -0.004, 0.002, 0.001], 1e-6, Verdict.REFUTED),
        ([0.009, -0.004, 0.002, -0.02], 1e-6, Verdict.REFUTED),
        ([0.009, -0.004, 0.002, 0.001], 1e-3, Verdict.INCONCLUSIVE),
        ([0.011, -0.004, 0.002, 0.001], 1e-3, Verdict.INCONCLUSIVE),
        ([0.009, np.nan, 0.002, 0.001], 1e-6, Verdict.INCONCLUSIVE),
    ],
)
def test_errors_without_sampling(errors, floor, verdict):
    """All step sizes must be within the bound, whatever the errors can be off; one that is beyond refutes."""
    assert bias_of_operator(0.01, H, np.array(errors), np.full(4, floor), TOLD)[1].verdict is verdict


def test_a_mean_that_a_symmetry_fixes_tells_nothing():
    """No bias is claimed of what has none in any scheme."""
    fixed = FunctionalOrder(np.nan, -np.inf, np.inf, informative=False, fixed=True, note="a symmetry fixes it")

    assert bias_of_operator(0.01, H, np.zeros(4), np.full(4, 1e-9), fixed)[1].verdict is Verdict.NOT_APPLICABLE


def chains(bias, se):
    """Return what chains say of a bound of 0.01 where the bias is given, with its standard error."""
    noise = np.random.default_rng(7).standard_normal((GROUPS, len(H)))
    noise = (noise - noise.mean(axis=0)) / noise.std(axis=0, ddof=1)
    values = 1.0 + np.array(bias) + se * np.sqrt(GROUPS) * noise
    return bias_of_chains(0.01, [BiasSample(H, values, values[:, 0], 1.0, 1e-14)], 3.0, EVIDENCE)


@pytest.mark.parametrize(
    ("bias", "se", "verdict"),
    [
        ([0.0, 0.0, 0.002, 0.0], 0.001, Verdict.VERIFIED),
        ([0.0, 0.0, 0.002, 0.0], 0.004, Verdict.INCONCLUSIVE),
        ([0.0, 0.0, 0.02, 0.0], 0.001, Verdict.REFUTED),
        ([0.0, 0.0, -0.02, 0.0], 0.001, Verdict.REFUTED),
        ([0.0, 0.0, 0.012, 0.0], 0.001, Verdict.INCONCLUSIVE),
        ([0.01, 0.0, 0.0, 0.0], 0.001, Verdict.INCONCLUSIVE),
    ],
)
def test_errors_of_chains(bias, se, verdict):
    """The interval at each step size has to lie within the bound, or one of them outside; else chains are missing."""
    found, opinion = chains(bias, se)

    assert opinion.verdict is verdict
    assert (found.growth > 1.0) is (verdict is Verdict.INCONCLUSIVE)


def test_chains_at_the_boundary_decide_as_often_as_their_level_says():
    """With a bias of just the bound at one step size, neither verdict comes in more than 1 % of the samples."""
    rng = np.random.default_rng(3)
    decided = 0
    for _ in range(400):
        values = np.array([1.01, 1.0, 1.0, 1.0]) + 1e-3 * rng.standard_normal((GROUPS, len(H)))
        sample = BiasSample(H, values, values[:, 0], 1.0, 1e-14)
        decided += bias_of_chains(0.01, [sample], 1.0, EVIDENCE)[1].verdict is not Verdict.INCONCLUSIVE

    # Two tests of 0.005 each: 12 of 400 have a probability below 1e-3.
    assert decided < 12


@pytest.mark.parametrize(("share", "verdict"), [(1.1, "verified"), (0.9, "refuted")])
def test_the_bias_of_euler_on_ou_is_told_from_the_bound(share, verdict):
    """Its variance is sigma^2/(2 - h): a bound a tenth above the error at the largest step holds, not one below."""
    most = float(euler_variance(0.25) - euler_variance(0.0))

    assert invariant(Within(share * most))["x^2"] == verdict


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", [MALA(), Shaken()])
def test_mala_is_verified_by_detailed_balance_and_by_chains(scheme):
    """With the proposal's density the means are right at all step sizes."""
    assert set(invariant(scheme).values()) == {"verified"}


@pytest.mark.long
def test_a_bound_is_refuted_where_chains_diverge():
    """Euler-Maruyama leaves the double well at h = 1/4: however wide a bound is, it has no mean there."""
    found = verify([Within(10.0)], "double-well", "invariant").verdicts

    assert dict(zip(found["quantity"], found["verdict"], strict=True))["x^2"] == "refuted"
    assert any("hains diverge at h = 0.25" in reason for reason in found["reason"])


@pytest.mark.long
def test_divergence_is_the_cause_that_is_told():
    """Not the bias of the chains that are left, which is within the bound; a bias beyond one is told."""
    diverging, biased = (
        verify([scheme], problem, "invariant").verdicts.set_index("quantity").loc["x^2"]
        for scheme, problem in ((Within(10.0), "double-well"), (Within(0.01), "ou"))
    )
    assert diverging["verdict"] == biased["verdict"] == "refuted"
    assert diverging["reason"].startswith("Chains diverge at h = 0.25, so that no stationary mean exists")
    assert "largest bias -0.03" not in diverging["reason"]
    assert np.isnan(diverging["value"])
    assert abs(biased["value"]) > 0.01


def test_a_step_that_jumps_has_no_operator():
    """What says that it accepts or rejects is not judged at nodes."""
    assert "discontinuous" in why_not_operator(MALA(), ou())
    assert not why_not_operator(AcceptsAll(), ou())


def test_bounds_are_of_claims_in_words():
    """A bound is positive, and belongs to words; a claim to be unbiased has one."""
    right = {"measure": "invariant", "value": "unbiased", "bound": 0.08, "source": "test"}

    assert str(Claim(**right)) == str(MALA.claims[0]) == "unbiased within 0.08"
    for wrong in ({"bound": 0.0}, {"bound": np.inf}, {"bound": None}, {"value": 1.0}, {"share": 0.0}):
        with pytest.raises(Exception, match="bound"):
            Claim(**{**right, **wrong})


def test_the_step_of_mala_on_ou_is_in_detailed_balance():
    """rho(x) q(x, y) min(1, e^a(x, y)) is the same from y to x, with the normal densities of `ou`."""
    problem, h = ou(a=1.5, sigma=0.7), 0.3
    x, y = np.random.default_rng(1).standard_normal((2, 1, 50))

    def flow(x, y):
        density = -(x**2) * 1.5 / 0.49 - (y - x + h * 1.5 * x) ** 2 / (2.0 * 0.49 * h)
        return density + np.minimum(0.0, log_ratio(problem, 0.0, h, x, y))

    assert np.abs(flow(x, y) - flow(y, x)).max() <= 1e-12


@dataclass(frozen=True)
class HalfDrift(Scheme):
    """Euler-Maruyama with half of a linear drift, exact on trivial equations; it claims a bound of its biases."""

    bound: float = 1e6

    name: ClassVar[str] = "half-drift"
    form: ClassVar[type[SDE]] = SDE

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Return the claim."""
        return (Claim(measure="invariant", value="unbiased", bound=self.bound, source="test"),)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        drift = 2.0 * problem.drift(t, state) - problem.drift(t, 1.5 * state)
        return Step(state + h * drift + problem.diffused(t, state, noise.dW))


@pytest.mark.sweep
@pytest.mark.parametrize(("bound", "verdict"), [(1e6, "inconclusive"), (0.9, "inconclusive"), (0.2, "refuted")])
def test_a_bound_that_is_no_less_than_the_observable_verifies_nothing(bound, verdict):
    """The spread of x^2 is 0.84 on ou: a bound beyond it is no claim, and one below it is tested."""
    assert invariant(HalfDrift(bound))["x^2"] == verdict


@pytest.mark.parametrize(("bound", "verdict"), [(0.8, "verified"), (5.0, "inconclusive")])
def test_a_right_scheme_with_a_vacuous_claim_is_told_so(bound, verdict):
    """A bound just below the spread is verified where it holds; the reason of a vacuous one names both numbers."""
    rows = verify([Within(bound)], "ou", "invariant").verdicts.set_index("quantity")
    assert rows.verdict["x^2"] == verdict
    vacuous = "the claimed bound 5 is not below the size of the quantity, 0.84, so that no error exceeds it"
    assert (vacuous in rows.reason["x^2"].lower()) is (verdict == "inconclusive")


@pytest.mark.parametrize(("most", "size", "held"), [(1.0, 1.0, True), (0.9, 1.0, False), (9.0, 0.0, False)])
def test_tests_of_a_vacuous_bound_verify_nothing(most, size, held):
    """Without a known size nothing is held back; what speaks against a claim stays."""
    tests = PathTests(1e-9, 0.3, Reason("figures")).unless_vacuous(most, size)
    assert tests.verified == (1.0 if held else 1e-9)
    assert tests.refuted == 0.3
