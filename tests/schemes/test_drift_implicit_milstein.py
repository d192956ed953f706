"""The drift-implicit scheme of Milstein for equations of index 1, and wrong twins of it on random members."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    Drift,
    DriftImplicitMilstein,
    Strong,
    Weak,
    exactness_violation,
    member_classes,
    member_rows,
)
from sdaeverify import Array, DelayState, Increment, IndexOneSDAE, Step
from sdaeverify.measuring import Verdict
from sdaeverify_schemes.delays import drift_implicit_milstein

SEED = 1
RIGHT = drift_implicit_milstein.milstein_term


@dataclass(frozen=True)
class Wrong(DriftImplicitMilstein):
    """The scheme with a mistake.

    Attributes
    ----------
    flaw : str
        ``old``: y solves the constraint at the old time. ``drift``: a hundredth of the drift at the begin is added.
    """

    flaw: str = ""

    name: ClassVar[str] = "planted-drift-implicit-milstein"

    def step(self, problem: IndexOneSDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        made = super().step(problem, state, t, h, noise)
        if self.flaw == "old":
            x = made.state.x
            return made._replace(state=DelayState(x, problem.eliminated(t, x, x)))
        if self.flaw == "drift":
            x = made.state.x + 0.01 * h * problem.drift(t, state.x, state.x, state.y)
            return made._replace(state=DelayState(x, problem.eliminated(t + h, x, x)))
        return made


def sign(problem: IndexOneSDAE, state: DelayState, t: float, h: float, dW: Array) -> Array:
    """Return the term with the wrong sign."""
    return -RIGHT(problem, state, t, h, dW)


def variance(problem: IndexOneSDAE, state: DelayState, t: float, h: float, dW: Array) -> Array:
    """Return the term with -h for h."""
    return RIGHT(problem, state, t, -h, dW)


def noise(problem: IndexOneSDAE, state: DelayState, t: float, h: float, dW: Array) -> Array:
    """Return the term of -dW, which is the same."""
    return RIGHT(problem, state, t, h, -dW)


def rows(scheme: DriftImplicitMilstein) -> dict[tuple[str, float], Verdict]:
    """Return the verdicts on random members by measure and claimed order."""
    kinds = member_classes(scheme, SEED)
    found = (row for kind in kinds for row in member_rows(scheme, kind, [Strong(), Weak()], SEED))
    return {(row.measure, row.claim): row.verdict for row in found}


def drifts(scheme: DriftImplicitMilstein) -> set[Verdict]:
    """Return the verdicts on the residual of the constraint on random members."""
    kinds = member_classes(scheme, SEED)
    return {row.verdict for kind in kinds for row in member_rows(scheme, kind, [Drift()], SEED)}


@pytest.mark.long
def test_all_orders_are_verified_on_random_members() -> None:
    """Strong order 1/2, 1 for one Brownian motion, and weak order 1."""
    expected = [("strong", 0.5), ("strong", 1.0), ("weak", 1.0)]
    assert rows(DriftImplicitMilstein()) == dict.fromkeys(expected, Verdict.VERIFIED)


def test_order_1_is_claimed_for_one_motion_alone() -> None:
    """Members with several motions do not commute, and have strong order 1/2."""
    kinds = {
        kind.name: [claim.value.least for claim in claims if claim.measure == "strong"]
        for kind, claims in member_classes(DriftImplicitMilstein(), SEED).items()
    }
    assert kinds == {"IndexOneSDAE": [0.5], "IndexOneSDAE without motions": [1.0]}


def test_an_algebraic_component_at_the_old_time_is_no_solution() -> None:
    """A constraint that is solved at the begin of the step does not hold at its end, as the right one does."""
    assert drifts(DriftImplicitMilstein()) == {Verdict.VERIFIED}
    assert drifts(Wrong("old")) == {Verdict.REFUTED}


@pytest.mark.long
def test_a_hundredth_of_a_further_drift_is_refuted() -> None:
    """T0 finds it on motion along a line."""
    assert exactness_violation(DriftImplicitMilstein()) == ""
    assert "not exact on dx = c dt" in exactness_violation(Wrong("drift"))


@pytest.mark.long
@pytest.mark.parametrize("change", [sign, variance])
def test_a_wrong_term_is_refuted(change: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong sign costs strong order 1, a wrong variance all of them."""
    monkeypatch.setattr(drift_implicit_milstein, "milstein_term", change)
    found = rows(DriftImplicitMilstein())
    assert found["strong", 1.0] is Verdict.REFUTED
    assert (found["weak", 1.0] is Verdict.REFUTED) == (change is variance)


@pytest.mark.long
def test_the_sign_of_the_noise_is_no_matter_where_it_is_squared(monkeypatch: pytest.MonkeyPatch) -> None:
    """An equivalent change is verified like the right scheme."""
    monkeypatch.setattr(drift_implicit_milstein, "milstein_term", noise)
    assert set(rows(DriftImplicitMilstein()).values()) == {Verdict.VERIFIED}


@pytest.mark.long
def test_a_derivative_that_does_not_follow_the_constraint_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The noise depends on y, and y on x: without dg/dy the strong order is 1/2."""
    monkeypatch.setattr(drift_implicit_milstein, "follow", lambda problem, state, t, z: np.zeros_like(state.y))
    found = rows(DriftImplicitMilstein())
    assert found["strong", 1.0] is Verdict.REFUTED
    assert found["strong", 0.5] is Verdict.VERIFIED
