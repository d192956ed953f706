"""Orders and verdicts from defects that are prescribed as functions of h."""

import numpy as np
import pytest

from facade import LocalWeak, judge_weak, weak_order
from facade import test_functions as phi
from facade import weak_defects_LEVELS as LEVELS
from sdaeverify.measuring import Kind, Verdict

H = LEVELS
FUNCTIONS, STATES = len(phi.names(1)), 13


def record(defect, exceptional=None, where=None, trees=5):
    """Return a record with one defect everywhere, but another one for some functions and states."""
    defects = np.tile(defect, (FUNCTIONS, STATES, 1))
    if where is not None:
        defects[where] = exceptional
    each = np.full(STATES, float(trees)), np.array(1.0), np.zeros(STATES), np.zeros(STATES)
    return LocalWeak(H, defects, np.ones_like(defects), *each, np.zeros((FUNCTIONS, 0, len(H))), np.zeros(len(H)))


def judged(claim, *given, **more):
    found = weak_order(record(*given, **more))
    return found, judge_weak(found, claim)


@pytest.mark.parametrize("power", [1.5, 2.0, 2.5, 3.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_powers_are_found(power, sign):
    """C h^(p + 1) (1 + a h) has the order p, half-integer ones included."""
    found, opinion = judged(power - 1.0, sign * 0.3 * H**power * (1.0 - 2.0 * H))
    assert found.order == pytest.approx(power - 1.0, abs=0.01)
    assert opinion.verdict is Verdict.VERIFIED


def test_the_error_of_the_reference_is_no_order():
    """Where three trees were extrapolated, a defect of the order 3 is theirs."""
    defect = 5.0 * H**4
    assert weak_order(record(defect, trees=3)).order == np.inf
    assert weak_order(record(defect)).order == pytest.approx(3.0, abs=0.02)


STEEP = 0.5 * H**3
# It changes its sign just before it meets the floor.
CROSSING = 0.02 * H**3 - 8.0 * H**4


def test_a_defect_that_changes_sign_is_left_out():
    """One whose leading coefficient is small tells nothing; it is counted in the reason."""
    found, opinion = judged(2.0, STEEP, CROSSING, (1, slice(0, 2)))
    assert np.nanmin(found.orders) < 1.75
    assert opinion.verdict is Verdict.VERIFIED
    assert "2 of 78 errors change sign" in str(opinion.reason)


def test_defects_that_move_at_many_states_decide_nothing():
    """The same at a quarter of the states is inconclusive: a lower order may be on its way."""
    _, opinion = judged(2.0, STEEP, CROSSING, (1, slice(0, 4)))
    assert opinion.verdict is Verdict.INCONCLUSIVE
    assert "still changing with h" in str(opinion.reason)


def test_orders_on_both_sides_of_a_change_of_sign_are_not_extrapolated():
    """Across it and just behind it local orders may be low and nearly equal by chance: that refutes nothing."""
    turn = 2.0**-11 / 0.3
    _, opinion = judged(1.0, 1e-4 * H**2 * (1.0 - H / turn))
    assert opinion.verdict is Verdict.INCONCLUSIVE
    assert "still changing with h" in str(opinion.reason)


def test_an_order_is_known_again_behind_a_change_of_sign():
    """Two halvings behind it a low order is found as if there had been none."""
    _, opinion = judged(1.0, 1e-4 * H - 0.5 * H**2)
    assert opinion.verdict is Verdict.REFUTED
    assert "weak order 0.00" in str(opinion.reason)


@pytest.mark.parametrize(
    ("states", "verdict"), [(1, Verdict.INCONCLUSIVE), (3, Verdict.INCONCLUSIVE), (4, Verdict.REFUTED)]
)
def test_a_low_order_at_isolated_states_decides_nothing(states, verdict):
    """One test function at a quarter of the states refutes; fewer may be singular."""
    _, opinion = judged(2.0, STEEP, 0.5 * H**2, (3, slice(0, states)))
    assert opinion.verdict is verdict
    assert "of E[x1^4]" in str(opinion.reason)


@pytest.mark.parametrize(("power", "inconsistent"), [(1.0, True), (1.5, False)])
def test_an_order_below_its_claim_is_refuted_and_an_order_of_0_is_inconsistent(power, inconsistent):
    """A step of order 0 in law has another limit, which speaks against all claims of the scheme on the problem."""
    _, opinion = judged(1.0, 0.1 * H**power)
    assert opinion.verdict is Verdict.REFUTED
    assert opinion.reason.has(Kind.INCONSISTENT) is inconsistent


def noisy(power, size):
    """Return defects of many functions and states with errors of a solver that jump about."""
    errors = np.random.default_rng(5).uniform(-size, size, (FUNCTIONS, STATES, len(H)))
    coefficients = np.linspace(0.1, 1.0, FUNCTIONS * STATES).reshape(FUNCTIONS, STATES, 1)
    return record(0.0 * H)._replace(defect=coefficients * H**power + errors)


def test_a_few_defects_that_a_solver_stops_refute_nothing():
    """Too few for a plateau, they are no powers of h either: their orders are not known."""
    _, opinion = judged(1.0, 0.1 * H**2, 0.1 * H**2 + 1e-10, (2, slice(0, 4)))
    assert opinion.verdict is Verdict.INCONCLUSIVE


def test_a_plateau_that_leaves_too_few_levels_hides_the_order():
    """Nothing is said of an order of which only coarse steps are left."""
    opinion = judge_weak(weak_order(noisy(3.0, 1e-7)), 2.0)
    assert opinion.verdict is Verdict.INCONCLUSIVE
    assert "tolerance" in str(opinion.reason)


def test_a_large_plateau_is_a_wrong_limit():
    """Defects that stay above one in a million are no solver's tolerance, but a step that does not shrink with h."""
    _, opinion = judged(1.0, 0.1 * H**2 + 1e-4)
    assert opinion.verdict is Verdict.REFUTED


def test_no_finite_step_is_no_order():
    """Where the finest step is not finite, its state has no order."""
    _, opinion = judged(1.0, 0.1 * H**2, np.where(H < 2.0**-15, np.nan, H), (slice(None), 5))
    assert opinion.verdict is Verdict.INCONCLUSIVE
