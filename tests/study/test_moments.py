"""Claims in mean square are not verified where moments of the scheme grow without bound."""

from typing import ClassVar

import numpy as np
import pytest

from facade import EulerMaruyama, Invariant, TamedEuler, double_well, gbm
from sdaeverify import SDE, Array, Claim, Increment, Scheme, SchemeError, Step, UsageError, verify
from sdaeverify.measuring import Verdict

MEASURES = ("strong", "weak", "invariant")
OPTIONS = {"paths": 1024, "max_looks": 1}


class Explicit(Scheme):
    """Euler's scheme as a third party registers it: without a sense, orders are claimed in mean square."""

    name: ClassVar[str] = "explicit"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source="test", when=frozenset({"additive-noise"})),
        Claim(measure="strong", value=0.5, source="test"),
        Claim(measure="weak", value=1.0, source="test"),
        Claim(measure="invariant", value=1.0, source="test"),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


class Guarded(Explicit):
    """The same with a drift that is bounded by 1/h beyond |x| = 1/h."""

    name: ClassVar[str] = "guarded"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        f = problem.drift(t, state)
        return Step(state + h * np.clip(f, -1.0 / h, 1.0 / h) + problem.diffused(t, state, noise.dW))


class InProbability(Explicit):
    """The same with its orders claimed in probability."""

    name: ClassVar[str] = "local"
    claims: ClassVar[tuple[Claim, ...]] = tuple(
        Claim(measure=c.measure, value=c.value, source="test", when=c.when, sense="in probability")
        for c in Explicit.claims
    )


def power_1_5() -> SDE:
    """Return dx = -x |x|^(1/2) dt + dW."""
    return SDE(
        drift=lambda t, x: -x * np.sqrt(np.abs(x)), diffusion=lambda t, x: np.ones((1, 1, 1)), start=[0.5],
        noise_dim=1, horizon=1.0, traits=frozenset({"additive-noise"}), source="test",
    )  # fmt: skip


def found(scheme, problem, measures=MEASURES):
    """Return the findings on claims, by measure."""
    result = verify([scheme], [problem], list(measures), **OPTIONS)
    claimed = [row for row in result.verdicts.itertuples() if row.claim]
    return {name: [row for row in claimed if row.measure == name] for name in measures}


def test_orders_in_mean_square_are_not_verified_where_moments_diverge():
    """Of Euler's scheme on a cubic drift, whose local orders are right."""
    rows = found(Explicit(), double_well)

    assert {row.verdict for name in MEASURES for row in rows[name]} == {Verdict.INCONCLUSIVE}
    for row in (*rows["strong"], *rows["weak"]):
        assert "sense='in probability'" in row.reason
    assert all("no invariant law" in row.reason for row in rows["invariant"])
    assert "order 1.00 from one step" in rows["strong"][0].reason


def test_orders_in_probability_are_verified_there_and_no_invariant_law_is():
    """Local conditions are enough for paths, and for means without exploding paths; an invariant law needs more."""
    rows = found(InProbability(), double_well)

    assert {row.verdict for row in rows["strong"]} == {Verdict.VERIFIED}
    assert {row.claim for row in rows["strong"]} == {"order >= 1.0 in probability"}
    assert {row.verdict for row in rows["weak"]} == {Verdict.VERIFIED}
    assert {row.verdict for row in rows["invariant"]} == {Verdict.INCONCLUSIVE}


def test_a_wrong_order_in_probability_is_refuted_where_moments_diverge():
    """The sense is no way around what one step shows."""

    class Bold(InProbability):
        name: ClassVar[str] = "bold"
        claims: ClassVar[tuple[Claim, ...]] = (
            Claim(measure="strong", value=1.5, source="test", sense="in probability"),
            Claim(measure="weak", value=2.0, source="test", sense="in probability"),
        )

    rows = found(Bold(), double_well, ("strong", "weak"))
    assert {row.verdict for name in rows for row in rows[name]} == {Verdict.REFUTED}


@pytest.mark.parametrize("scheme", [TamedEuler(), pytest.param(Guarded(), marks=pytest.mark.long)])
def test_orders_in_mean_square_stay_verified_where_a_scheme_has_moments(scheme):
    """Of tamed schemes on a cubic drift."""
    rows = found(scheme, double_well, ("strong", "weak"))

    assert {row.verdict for name in rows for row in rows[name]} == {Verdict.VERIFIED}
    assert all("probability" not in row.claim for name in rows for row in rows[name])


@pytest.mark.long
def test_orders_in_mean_square_stay_verified_for_linear_coefficients():
    """Of Euler's scheme on a linear equation."""
    for scheme in (Explicit(), EulerMaruyama()):
        rows = found(scheme, gbm, ("strong", "weak"))
        assert {row.verdict for name in rows for row in rows[name]} == {Verdict.VERIFIED}
        assert {row.claim for row in rows["strong"]} == {"order >= 0.5"}


@pytest.mark.long
def test_a_drift_of_power_three_halves_is_enough():
    """Any power above 1 is, and 1.5 is seen."""
    rows = found(Explicit(), power_1_5, ("strong",))["strong"]
    assert {row.verdict for row in rows} == {Verdict.INCONCLUSIVE}


def test_shipped_explicit_schemes_say_in_which_sense_their_orders_hold():
    """In mean square where coefficients grow linearly, in probability elsewhere; no invariant order there."""
    rows = found(EulerMaruyama(), double_well)

    assert {row.claim for row in rows["strong"]} == {"order >= 1.0 in probability"}
    assert {row.verdict for row in (*rows["strong"], *rows["weak"])} == {Verdict.VERIFIED}
    assert not rows["invariant"]


def test_an_unknown_sense_is_refused():
    """A claim says one of two things."""
    with pytest.raises((UsageError, SchemeError), match="in probability"):
        Claim(measure="strong", value=1.0, source="test", sense="almost surely")


def test_the_invariant_measure_follows_the_stationary_law():
    """That is what it needs to be told of chains that explode."""
    assert Invariant.follows == "stationary law"
