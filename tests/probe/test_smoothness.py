"""Jumps and kinks of observables are found where solutions go, and smooth functions are not taken for them."""

from dataclasses import replace

import numpy as np
import pytest

from contradictions import bent_drift, kinked, squared_motion, switched_late, switched_on_mesh, waves
from facade import (
    EulerMaruyama,
    Roughness,
    Smoothness,
    circle,
    delay_ou,
    gbm,
    noncommuting,
    pendulum,
    pendulum_tangential,
    pendulum_velocity_noise,
    rough_coefficient,
    smoothness,
    sphere_langevin,
)

FUNCTIONS = {
    Smoothness.JUMP: {
        "indicator": lambda x: 1.0 * (x > 1.0),
        "a thousandth": lambda x: x + 1e-3 * (x > 1.3),
        "sign": lambda x: np.sign(x - 0.9),
        "floor": lambda x: np.floor(10.0 * x),
        "window": lambda x: 1.0 * (np.abs(x - 1.0) < 0.05),
    },
    Smoothness.KINK: {
        "modulus": lambda x: np.abs(x - 1.2),
        "call": lambda x: np.maximum(x - 1.1, 0.0),
        "square root": lambda x: np.sqrt(np.abs(x - 1.0)),
        "a hundredth": lambda x: x**2 + 0.01 * np.abs(x - 1.0),
    },
    Smoothness.SMOOTH: {
        "power": lambda x: x**20,
        "wave": lambda x: np.sin(40.0 * x),
        "steep": lambda x: np.tanh(300.0 * (x - 1.0)),
        "growth": lambda x: np.exp(5.0 * x),
        "constant": np.ones_like,
        "line": lambda x: 3.0 * x,
        "large and flat": lambda x: 1e8 + 1e-9 * x**2,
        "second derivative jumps": lambda x: np.maximum(x - 1.0, 0.0) ** 2,
    },
}


def found(function, problem=None):
    """Return what is found of a function of the first component."""
    observables = {"q": lambda t, parts: function(parts["x"][0])}
    return smoothness(replace(problem or gbm(), observables=observables, truths=()), "q")


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, named in FUNCTIONS.items() for name in named])
def test_jumps_and_kinks_are_found_and_told_from_smooth_functions(kind, name):
    """At whatever place between two states; neither steepness nor rounding is a kink."""
    assert found(FUNCTIONS[kind][name]) is kind


@pytest.mark.parametrize("problem", [circle(), noncommuting(), delay_ou()])
def test_other_forms_are_looked_at_as_well(problem):
    """In several components, on a manifold, with a delay."""
    start = float(problem.parts(problem.initial(1))["x"][0, 0])
    assert found(lambda x: 1.0 * (x > start), problem) is Smoothness.JUMP
    assert found(lambda x: np.abs(x - start), problem) is Smoothness.KINK
    assert found(np.sin, problem) is Smoothness.SMOOTH


def test_what_solutions_do_not_reach_does_not_count():
    """A jump at 1000 is none for growth that starts at 1."""
    assert found(lambda x: 1.0 * (x > 1e3)) is Smoothness.SMOOTH


@pytest.mark.parametrize(
    ("problem", "rough"),
    [
        (kinked(), Roughness("diffusion", lipschitz=True)),
        (bent_drift(), Roughness("drift", lipschitz=True)),
        (squared_motion(), Roughness("diffusion", lipschitz=False)),
        (replace(bent_drift(), drift=lambda t, x: np.sign(x)), Roughness("drift", lipschitz=False)),
        (waves(), None),
        (replace(waves(), drift=lambda t, x: -50.0 * x**3), None),
        (replace(bent_drift(), drift=lambda t, x: np.maximum(x - 50.0, 0.0)), None),
        (switched_late(), Roughness("diffusion", lipschitz=True, in_time=True)),
        (switched_on_mesh(), Roughness("diffusion", lipschitz=True, in_time=True)),
        (replace(waves(), drift=lambda t, x: x * np.floor(3.0 * t)), Roughness("drift", True, in_time=True)),
        (replace(waves(), drift=lambda t, x: x * np.sin(200.0 * t) + np.abs(t - 0.3)), None),
    ],
)
def test_coefficients_that_are_not_smooth_are_named(problem, rough):
    """A kink is told from an infinite slope and from a jump; where solutions do not go none counts."""
    assert rough_coefficient(problem) == rough


def without_jacobian(problem):
    """Return a problem whose constraint is differentiated for it, and the same as an SDE."""
    plain = replace(problem, jacobian=None, curvature=None)
    return plain, EulerMaruyama().view_of(plain)


@pytest.mark.sweep
@pytest.mark.parametrize("problem", [pendulum_velocity_noise(), pendulum_tangential(), sphere_langevin()])
def test_the_rounding_of_a_curvature_that_is_computed_is_no_kink(problem):
    """Second derivatives of a constraint are rounded a thousand times more than the constraint."""
    assert [rough_coefficient(view) for view in without_jacobian(problem)] == [None, None]


def test_kinks_are_found_beside_a_curvature_that_is_computed():
    """A force that is not smooth remains so, whoever differentiates the constraint."""
    bent = replace(pendulum_velocity_noise(), force=lambda t, r, v: -np.abs(v - 0.4))
    assert {rough_coefficient(view) for view in without_jacobian(bent)} == {Roughness("drift", lipschitz=True)}


def test_an_observable_of_an_unknown_component_is_left_alone():
    """It is not judged either."""
    assert smoothness(EulerMaruyama().view_of(pendulum()), "mu") is Smoothness.SMOOTH
