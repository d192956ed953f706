"""Local weak orders of schemes whose order is known, and of planted wrong ones."""

from dataclasses import replace

import numpy as np
import pytest

from facade import (
    HalfExplicitEuler,
    WrongVariance,
    fibre_free,
    judge_weak,
    levy_area,
    local_weak,
    pendulum,
    weak_order,
    weak_reference,
    why_not_local_weak,
)
from facade import weak_defects_LEVELS as LEVELS
from probe.strong_cells import Altered, multiplier_noise
from probe.weak_cells import CORRECT, PLANTED, PROBLEMS, SIGMA, A, B, equation, euler, order, reference, scheme
from sdaeverify import THREE_POINT, ProblemError
from sdaeverify.measuring import Verdict
from sdaeverify.numerics import apply


@pytest.mark.sweep
@pytest.mark.parametrize("name", CORRECT)
def test_correct_schemes_have_their_order(name):
    """The order is found within 0.02, the claim of it is verified and that of the next half order refuted."""
    tested, problem, known = CORRECT[name]
    found = order(tested, problem)
    assert found.order == pytest.approx(known, abs=0.02)
    assert judge_weak(found, min(known, 5.0)).verdict is Verdict.VERIFIED
    if np.isfinite(known):
        assert judge_weak(found, known + 0.5).verdict is Verdict.REFUTED


@pytest.mark.parametrize("name", PLANTED)
def test_planted_schemes_are_refuted(name):
    """Every planted error is refuted, with an order of 0 where the limit itself is wrong."""
    tested, problem, claim, wrong_limit = PLANTED[name]
    found = order(tested, problem)
    assert judge_weak(found, claim).verdict is Verdict.REFUTED
    assert (found.order < 0.25) is wrong_limit


def test_a_wrong_pure_output_is_found():
    """What no coefficient depends on is compared with its equation all the same."""
    forgetful = Altered(HalfExplicitEuler(truncation="none"), multiplier_noise)
    opinion = judge_weak(weak_order(local_weak(forgetful, pendulum(), reference)), 1.0)
    assert opinion.verdict is Verdict.REFUTED


def test_a_wrong_variance_is_found_on_the_inherent_equation():
    """A constrained problem seen as an SDE is probed like any other."""
    view = pendulum().view(WrongVariance.form)
    assert judge_weak(weak_order(local_weak(WrongVariance(0.05), view)), 1.0).verdict is Verdict.REFUTED


def test_orders_do_not_depend_on_units():
    """A solution a million times as large has the same orders."""
    large = equation(lambda t, x: A * x, lambda t, x: B * x[:, None], [1e6])
    found = weak_order(local_weak(scheme(euler), large))
    same = order(scheme(euler), "gbm")
    assert found.order == pytest.approx(same.order, abs=0.01)
    assert found.orders == pytest.approx(same.orders, abs=0.1)


ROTATION = np.array([[0.6, -0.8], [0.8, 0.6]])


def turned(p, x, t, h, n):
    """Euler-Maruyama in coordinates that are turned, and back: rounding of one coordinate enters the other."""
    return ROTATION.T @ (ROTATION @ x + h * (ROTATION @ p.drift(t, x)) + ROTATION @ apply(p.diffusion(t, x), n.dW))


def test_a_coordinate_that_is_0_up_to_rounding_has_no_unit_of_its_own():
    """Rounding errors of the state's size, in a coordinate that starts at 8e-17, are no defect of its moments."""
    first, there_and_back = np.array([[1.0], [0.0]]), ROTATION.T @ ROTATION
    flat = equation(
        lambda t, x: A * first * x, lambda t, x: B * (first * x)[:, None], [1.0, 8e-17],
        constraint=lambda x: x[1:] + (there_and_back @ x - x)[1:],
    )  # fmt: skip
    found = weak_order(local_weak(scheme(turned), flat))
    assert found.order == pytest.approx(1.0, abs=0.02)
    assert judge_weak(found, 1.0).verdict is Verdict.VERIFIED
    assert judge_weak(found, 1.5).verdict is Verdict.REFUTED


def test_a_small_coordinate_keeps_its_unit():
    """A coordinate a billion times smaller than another one is still seen: a wrong variance of it is refuted."""
    size = np.array([[1.0], [1e-9]])
    small = equation(lambda t, x: A * x, lambda t, x: np.eye(2)[..., None] * B * x, [1.0, 1e-9], noise_dim=2)

    def wrong(p, x, t, h, n):
        dW = n.dW * np.array([[1.0], [1.05]])
        return x + h * p.drift(t, x) + apply(p.diffusion(t, x), dW)

    assert np.all(small.initial(1) == size)
    assert judge_weak(weak_order(local_weak(scheme(wrong), small)), 1.0).verdict is Verdict.REFUTED


def correlated_at_rest(p, x, t, h, n):
    """Euler-Maruyama whose two noises are correlated where a path starts, and nowhere else."""
    dW = n.dW + 0.1 * n.dW[::-1] * (x[:2] == 0.0).all(axis=0)
    return x + h * p.drift(t, x) + apply(p.diffusion(t, x), dW)


def test_moments_without_slope_at_a_state_are_rounded_as_behind_it():
    """Where D phi = 0 at the start, rounding of sums that cancel is no defect, and a wrong covariance is one."""
    area = levy_area()
    found = weak_order(local_weak(scheme(euler), area, reference))
    assert found.orders.min() == pytest.approx(1.0, abs=0.02)
    assert judge_weak(found, 1.0).verdict is Verdict.VERIFIED
    wrong = weak_order(local_weak(scheme(correlated_at_rest), area, reference))
    places = np.flatnonzero((wrong.settled & (wrong.orders < 0.02)).any(axis=0))
    assert places.tolist() == [0]


@pytest.mark.long
def test_a_fibre_at_rest_in_a_turbulent_flow_has_its_order():
    """Of 13 states of a truncated scheme four are left, one at rest: no moment there is refuted by rounding."""
    fibre = fibre_free(alpha=4.0, beta=0.0669, N=2, d=3, horizon=0.05)
    assert judge_weak(weak_order(local_weak(HalfExplicitEuler(), fibre)), 1.0).verdict is Verdict.VERIFIED
    forgetful = Altered(HalfExplicitEuler(), multiplier_noise)
    assert judge_weak(weak_order(local_weak(forgetful, fibre)), 1.0).verdict is Verdict.REFUTED


def bisected(p, x, t, h, n, *, tolerance, variance=1.0):
    """Solve x+ = x - h x+ + b dW by halving an interval down to a tolerance."""
    known = x + np.sqrt(variance) * SIGMA * n.dW
    low, high = known - 4.0, known + 4.0
    for _ in range(int(np.ceil(np.log2(8.0 / tolerance)))):
        middle = 0.5 * (low + high)
        below = middle * (1.0 + h) < known
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return 0.5 * (low + high)


@pytest.mark.parametrize("tolerance", [1e-7, 1e-8, 1e-9])
def test_a_solver_plateau_is_dropped_and_reported(tolerance):
    """Above its solver's tolerance drift-implicit Euler has order 1; the claim is void below a step size."""
    found = order(scheme(bisected, tolerance=tolerance), "ou")
    opinion = judge_weak(found, 1.0)
    assert opinion.verdict is Verdict.VERIFIED
    assert 0.0 < found.plateau_h < 1e-3
    assert f"h below {found.plateau_h:.2g} left out" in str(opinion.reason)


def test_a_plateau_hides_no_wrong_limit():
    """With a sloppy solver, too, a variance wrong by one per cent is refuted."""
    assert judge_weak(order(scheme(bisected, tolerance=1e-8, variance=1.01), "ou"), 1.0).verdict is Verdict.REFUTED


def test_overflow_at_coarse_steps_is_no_matter():
    """Only the fine end decides: a scheme that is lost at large steps keeps its order."""

    def lost(p, x, t, h, n):
        return euler(p, x, t, h, n) * (np.inf if h > 2.0**-6 else 1.0)

    assert order(scheme(lost), "gbm").order == pytest.approx(1.0, abs=0.02)


def test_pairs_that_cannot_be_probed_say_why():
    """Too many noises are refused with a reason."""
    assert why_not_local_weak(scheme(euler), PROBLEMS["gbm"]) == ""
    many = equation(lambda t, x: -x, lambda t, x: np.ones((1, 12, 1)), [1.0], noise_dim=12)
    assert "12" in why_not_local_weak(scheme(euler), many)
    assert "12" in why_not_local_weak(scheme(euler, THREE_POINT), many)


def test_states_where_the_equation_is_not_finite_are_left_out():
    """A coefficient that is lost somewhere at later times does not spoil the other states."""

    def drift(t, x):
        return np.where((x < 0.9) & (t > 0.0), np.nan, A * x)

    whole, steps = PROBLEMS["gbm"], tuple((0.2, h) for h in LEVELS.tolist())
    part = weak_reference(replace(whole, drift=drift), steps)
    assert 0 < part.states.shape[1] < reference(whole, steps).states.shape[1]
    assert np.isfinite(part.means[..., -1]).all()
    with pytest.raises(ProblemError, match="not finite at any of the probed states"):
        weak_reference(replace(whole, drift=lambda t, x: A * x + (np.nan if t > 0.0 else 0.0)), steps)
