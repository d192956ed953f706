"""Errors of means from the transition operator against closed forms, another operator, and published figures."""

import numpy as np
import pytest

from facade import HalfExplicitEuler, chart_observables, functional_orders, least_order, ou, weak_errors
from probe.chart_cells import (
    ANGLE,
    AdditiveHeun,
    Euler,
    Splitting,
    free_moments,
    plane_pendulum,
    with_moments,
)
from sdaeverify import Step
from sdaeverify.probing import invariant_errors, invariant_observables

SIZES = [1 / 4, 1 / 8, 1 / 16, 1 / 32, 1 / 64]
UNTRUNCATED = HalfExplicitEuler(truncation="none")
# Direction of the start in which the leading weak error of v_2 vanishes at h = 2^-7 (omega_0 = T = 1/2).


def local_orders(errors):
    """Return the local orders of errors at halved step sizes."""
    return np.log2(np.abs(errors[:-1] / errors[1:]))


# ---------------------------------------------------------------- which observables


def test_observables_of_outputs_and_of_unwrapped_angles_are_no_functions_of_the_chart():
    """The multiplier is not known from the coordinates, and an angle not from its direction."""
    assert chart_observables(plane_pendulum()) == ("r_2", "v_1", "v_2", "r_1^2", "|v|^2")
    assert chart_observables(ANGLE) == ("cosine", "p", "square")


def test_stationary_errors_are_of_observables_whose_mean_is_known():
    """Nothing else can be wrong about a stationary law."""
    assert invariant_observables(plane_pendulum(gamma=1.0)) == ("r_2", "r_1^2", "|v|^2")
    assert invariant_observables(plane_pendulum()) == ()


# ---------------------------------------------------------------- stationary laws


def test_euler_has_the_known_stationary_orders():
    """Of E cos q on the angle pendulum, friction 1/2, noise 0.7: 1.20 1.11 1.06 1.03."""
    record = invariant_errors(Euler(), ANGLE, SIZES)
    assert local_orders(record.errors[:, 0]) == pytest.approx([1.20, 1.11, 1.06, 1.03], abs=0.006)
    assert record.resolution.max() < 1e-6


def test_a_step_that_does_not_move_is_called_that():
    """It keeps the stationary law that the operator begins with; a step that moves by a tenth of Euler's is wrong."""

    class Still(Euler):
        def step(self, problem, state, t, h, noise):
            return Step(state.copy())

    class Slow(Euler):
        def step(self, problem, state, t, h, noise):
            return Step(state + 0.1 * (super().step(problem, state, t, h, noise).state - state))

    still, slow = (functional_orders(invariant_errors(scheme, ou(), SIZES)) for scheme in (Still(), Slow()))

    assert {found.note for found in still} == {"a step returns its state unchanged"}
    assert not any(found.informative for found in still)
    assert least_order(slow)[1] < 0.1


def test_splitting_has_the_known_stationary_errors():
    """The same mean for BAOAB is off by 3.2e-5 to 1.3e-7, with orders 1.97 1.99 2.00 2.00."""
    errors = invariant_errors(Splitting(), ANGLE, SIZES).errors[:, 0]
    assert np.abs(errors[[0, -1]]) == pytest.approx([3.2e-5, 1.3e-7], rel=0.02)
    assert local_orders(errors) == pytest.approx([1.97, 1.99, 2.00, 2.00], abs=0.006)


def test_stationary_bias_of_the_half_explicit_scheme_is_the_known_one():
    """For a rotor E|v|^2 - kT = kT (gamma/2 + 3 kT/(2 gamma)) h + O(h^2), 0.625 h with gamma = 1 and kT = 1/2."""
    rotor = plane_pendulum(gamma=1.0, scale=np.sqrt(0.5))
    record = invariant_errors(UNTRUNCATED, rotor, [1 / 64, 1 / 128, 1 / 256])
    ratios = record.errors[:, invariant_observables(rotor).index("|v|^2")] / record.h
    # Extrapolated to h = 0, the square of the step size is left, times a few.
    assert 2.0 * ratios[1:] - ratios[:-1] == pytest.approx([0.625, 0.625], abs=10.0 / 64**2)


def test_truncation_spoils_the_stationary_law_of_large_steps_only():
    """At large h the tails are heavy and nothing is resolved; finer steps show order 1 with truncation as without."""
    rotor = plane_pendulum(c_g=1.0, gamma=1.0, scale=np.sqrt(0.5))
    record = invariant_errors(HalfExplicitEuler(), rotor, [2.0**-k for k in range(3, 9)])
    seen = np.abs(record.errors) > 10.0 * record.floors
    assert seen.all(axis=1).tolist() == [False] * 3 + [True] * 3
    assert record.truncated[0] > 1e-2
    low, high = least_order(functional_orders(record))
    assert 0.9 < low < high < 1.1


# ---------------------------------------------------------------- means at the final time


@pytest.mark.sweep
@pytest.mark.parametrize(("scheme", "order"), [(Euler(), 1.0), (AdditiveHeun(), 2.0)], ids=["euler", "heun"])
def test_weak_orders_on_the_angle_pendulum(scheme, order):
    """Against the semigroup of the generator Euler-Maruyama has order 1, Heun's scheme for additive noise 2."""
    low, high = least_order(functional_orders(weak_errors(scheme, ANGLE, [4, 8, 16, 32, 64])))
    assert abs(low - order) < 0.01
    assert abs(high - order) < 0.01


def chain_means(h, steps):
    """Return the means of `free_moments` for the half-explicit scheme, from the autonomous chain of omega alone.

    omega+ is normal with mean omega/cos phi and deviation sqrt(h)/cos phi, sin phi = h omega, and theta+ =
    theta + phi: a function a(omega) e^{ik theta} becomes e^{ik phi} E[a(omega+) | omega] e^{ik theta}, by the
    trapezoidal rule on the line.
    """
    omega = np.linspace(-7.0, 8.0, 1201)
    phi = np.arcsin(h * omega)
    deviation = np.sqrt(h) / np.cos(phi)
    z = (omega[None] - (omega / np.cos(phi))[:, None]) / deviation[:, None]
    kernel = np.exp(-0.5 * z * z) * (omega[1] - omega[0]) / (np.sqrt(2 * np.pi) * deviation[:, None])
    a = np.stack([np.ones_like(omega), omega, omega**2, np.ones_like(omega)], axis=1).astype(complex)
    k = np.array([1.0, 1.0, 0.0, 2.0])
    turn = np.exp(1j * np.outer(phi, k))
    for _ in range(steps):
        a = turn * (kernel @ a)
    turned, moving, square, twice = a[np.argmin(np.abs(omega - 0.5))] * np.exp(0.5j * k)
    return np.array([-turned.real, moving.real, moving.imag, square.real, 0.5 - 0.5 * twice.real])


def test_half_explicit_means_are_those_of_its_one_dimensional_chain():
    """Two operators for the same means agree to the error bound of the one."""
    pendulum = with_moments(plane_pendulum(), 0.5)
    record = weak_errors(UNTRUNCATED, pendulum, [16, 32])
    columns = [chart_observables(pendulum).index(name) for name in free_moments(0.5)]
    found = (record.errors + record.exact)[:, columns]
    expected = [chain_means(1 / 32, 16), chain_means(1 / 64, 32)]
    assert (np.abs(found - expected) <= record.resolution[:, columns] + 1e-12).all()
    assert record.resolution.max() < 1e-5


# ---------------------------------------------------------------- a projection that is singular at two points
