"""Planted bugs are small changes of correct schemes: with the right parameters they are those schemes."""

import numpy as np
import pytest

from sdaeverify.contracts.scheme import flatten
from sdaeverify.noise.brownian import Increment
from sdaeverify.probe.step.one_step import OneStep
from sdaeverify.probe.step.states import cloud
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_problems
from sdaeverify_planted._projection import project_step
from sdaeverify_planted.baoab import WrongBAOAB
from sdaeverify_planted.ellipse import WrongFixman, tangential
from sdaeverify_planted.euler_arguments import WrongPlaces
from sdaeverify_planted.euler_noise import WrongVariance
from sdaeverify_planted.heun_additive import WrongStages
from sdaeverify_planted.implicit_euler_ggl import WrongImplicitEuler
from sdaeverify_planted.milstein import ScaledCorrection
from sdaeverify_planted.multiplier import WithoutCoriolis
from sdaeverify_planted.pendulum import WrongHalfExplicit
from sdaeverify_planted.platen import WrongSupport, heavy
from sdaeverify_planted.sra1 import ScaledArea
from sdaeverify_planted.stability import AlmostHalf
from sdaeverify_schemes.half_explicit_euler import HalfExplicitEuler

H, T = 2.0**-5, 0.25
RIGHT = [
    (WrongVariance(0.0), "euler-maruyama", "gbm"),
    (WrongPlaces(), "euler-maruyama", "forced-ou"),
    (ScaledCorrection(0.5), "milstein", "gbm"),
    (ScaledArea(1.0), "sra1", "double-well"),
    (WrongStages(), "heun-additive", "forced-ou"),
    (WrongSupport(), "platen-weak-2", "gbm"),
    (WrongFixman(0.0), "projected-euler", "ellipse[measure=delta]"),
    (WrongBAOAB(), "baoab", "angle-pendulum"),
    (WrongHalfExplicit(), HalfExplicitEuler(truncation="none"), "damped-pendulum"),
    (WithoutCoriolis(), HalfExplicitEuler(truncation="none"), "damped-pendulum"),
    (AlmostHalf(0.5), "stochastic-theta", "linear-test"),
    (WrongImplicitEuler(), "implicit-euler-ggl", "damped-pendulum"),
]


@pytest.fixture(scope="module")
def registry():
    return load_registry(environ={}, lab=True)


def step(scheme, view):
    """Make one step from every state of the cloud, each with its own increment of the scheme's law."""
    one_step = OneStep(scheme, view)
    x = cloud(view, one_step.equation)
    rng = np.random.default_rng(7)
    dW, H_ = np.sqrt(H) * rng.standard_normal((2, view.noise_dim, x.shape[-1]))
    noise = scheme.law.increment(Increment(dW, H_ / np.sqrt(12.0)), H)
    return flatten(scheme.prepare(view, H)(one_step.enter(x, T, H), T, noise).state)


@pytest.mark.parametrize(("planted", "right", "problem"), RIGHT, ids=lambda thing: getattr(thing, "label", thing))
def test_right_parameters_give_the_right_scheme(registry, planted, right, problem):
    """What is planted differs from a shipped scheme by its parameters alone, up to rounding."""
    scheme = registry.schemes[right].make() if isinstance(right, str) else right
    view = select_problems(registry, problem)[0].build().view(scheme.form)

    expected = step(scheme, view)

    np.testing.assert_allclose(step(planted, view), expected, rtol=1e-12, atol=1e-14)


def test_fourth_moment_of_the_heavy_law():
    """The planted three-point law has variance 1 and fourth moment 4, and its coupling has these probabilities."""
    x = np.linspace(-8.0, 8.0, 400_001)
    density = np.exp(-0.5 * x * x) / np.sqrt(2 * np.pi) * (x[1] - x[0])

    assert heavy(x) ** 2 @ density == pytest.approx(1.0, abs=1e-4)
    assert heavy(x) ** 4 @ density == pytest.approx(4.0, abs=1e-4)


@pytest.mark.parametrize("problem", ["ellipse", "ellipse[measure=delta]"])
def test_radial_projection_differs_from_the_normal_one_by_its_direction(registry, problem):
    """The tangential step with the normals at its end agrees with projected Euler's mean up to order h^2."""
    view = select_problems(registry, problem)[0].build()
    right = registry.schemes["projected-euler"].make()
    x = cloud(view, view)
    nodes, weights = np.polynomial.hermite_e.hermegauss(12)
    weights = weights / weights.sum()

    def mean(scheme_step, h):
        noises = (Increment(np.full((1, x.shape[-1]), np.sqrt(h) * z), None) for z in nodes)
        return sum(w * scheme_step(h, noise) for w, noise in zip(weights, noises, strict=True))

    def normal(h, noise):
        y = tangential(view, x, T, h, noise)
        return project_step(view, x, y, view.dg(y)).state

    def radial(h, noise):
        y = tangential(view, x, T, h, noise)
        return project_step(view, x, y, y[None]).state

    def euler(h, noise):
        return right.step(view, x, T, h, noise).state

    sizes = np.array([2.0**-9, 2.0**-11])
    right_defects = [np.abs(mean(normal, h) - mean(euler, h)).max() for h in sizes]
    wrong_defects = [np.abs(mean(radial, h) - mean(euler, h)).max() for h in sizes]

    assert np.log2(right_defects[0] / right_defects[1]) / 2 == pytest.approx(2.0, abs=0.1)
    assert np.log2(wrong_defects[0] / wrong_defects[1]) / 2 == pytest.approx(1.0, abs=0.1)
