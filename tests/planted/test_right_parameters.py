"""Planted bugs are small changes of correct schemes: with the right parameters they are those schemes."""

import numpy as np
import pytest

from facade import HalfExplicitEuler, WrongVariance, flatten, load_registry, select_problems
from sdaeverify import Increment
from sdaeverify.probing import OneStep, cloud
from sdaeverify_lab.planted._within import ScaledEuler
from sdaeverify_lab.planted.coefficients import AlmostHalf, WrongStages, WrongTimes
from sdaeverify_lab.planted.higher_orders import OtherArea, ScaledCorrection, WrongSupport
from sdaeverify_lab.planted.mechanics import WithoutCoriolis, WrongBAOAB, WrongHalfExplicit, WrongImplicitEuler
from sdaeverify_lab.planted.projections import WrongFixman

H, T = 2.0**-5, 0.25
RIGHT = [
    (WrongVariance(0.0), "euler-maruyama", "gbm"),
    (WrongTimes(), "euler-maruyama", "forced-ou"),
    (ScaledEuler(), "euler-maruyama", "gbm"),
    (ScaledCorrection(0.5), "milstein", "gbm"),
    (OtherArea(), "sra1", "double-well"),
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
