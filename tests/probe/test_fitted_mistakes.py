"""Mistakes with numbers are named with the numbers that fit, if these explain the rates at all states."""

import numpy as np
import pytest

from facade import solved_instead
from sdaeverify import SDE, Array
from sdaeverify.numerics import apply

from .test_solved_instead import Wrong, diffusion, drift, generic


def changed(f=None, B=None) -> Wrong:
    """Return Euler-Maruyama with another drift or diffusion, functions of problem, time and state."""
    f = f or (lambda p, t, x: p.drift(t, x))
    B = B or (lambda p, t, x: p.diffusion(t, x))
    return Wrong(lambda p, t, x, h, dW: h * f(p, t, x) + apply(B(p, t, x), dW))


def along(p: SDE, t: float, x: Array, v: tuple[float, float]) -> Array:
    """Return f + B v."""
    return p.drift(t, x) + np.einsum("ijp,j->ip", p.diffusion(t, x), np.array(v))


NAMED = {
    "mean h": (
        changed(lambda p, t, x: along(p, t, x, (1.0, 1.0))),
        "the increments have a mean of size h: dW + h is used in place of dW",
    ),
    "means": (
        changed(lambda p, t, x: along(p, t, x, (1.0, -0.5))),
        "the increments have a mean of size h: dW + [1, -0.5] h is used in place of dW",
    ),
    "further x": (changed(lambda p, t, x: p.drift(t, x) + 0.7 * x), "there is a further drift 0.7 x"),
    "further constant": (
        changed(lambda p, t, x: p.drift(t, x) + np.array([[0.3], [-0.1]])),
        "there is a further drift [0.3, -0.1]",
    ),
    "drift at 2 t": (
        changed(lambda p, t, x: p.drift(2.0 * t, x)),
        "the drift is evaluated at 2 t in place of t",
    ),
    "diffusion at t/2": (
        changed(B=lambda p, t, x: p.diffusion(0.5 * t, x)),
        "the diffusion is evaluated at 0.5 t in place of t",
    ),
    "both at 1.5 t": (
        changed(lambda p, t, x: p.drift(1.5 * t, x), lambda p, t, x: p.diffusion(1.5 * t, x)),
        "the coefficients are evaluated at 1.5 t in place of t",
    ),
    "drift at 0.9 x": (
        changed(lambda p, t, x: p.drift(t, 0.9 * x)),
        "the drift is evaluated at 0.9 x in place of x",
    ),
    "diffusion at -x": (
        changed(B=lambda p, t, x: p.diffusion(t, -x)),
        "the diffusion is evaluated at -x in place of x",
    ),
    "both at 1.1 x": (
        changed(lambda p, t, x: p.drift(t, 1.1 * x), lambda p, t, x: p.diffusion(t, 1.1 * x)),
        "the coefficients are evaluated at 1.1 x in place of x",
    ),
    "drift at x reversed": (
        changed(lambda p, t, x: p.drift(t, x[::-1])),
        "the drift is evaluated at the components of the state in the order 2, 1",
    ),
    "drift reversed": (
        changed(lambda p, t, x: p.drift(t, x)[::-1]),
        "the components of the drift are in the order 2, 1",
    ),
}


@pytest.mark.sweep
@pytest.mark.parametrize(("scheme", "says"), NAMED.values(), ids=NAMED)
def test_mistakes_with_numbers_are_named(scheme, says):
    """Each family is named with its numbers."""
    assert solved_instead(scheme, generic()) == says


ALIKE = {
    "affine": changed(lambda p, t, x: p.drift(t, 0.9 * x + 0.1)),
    "affine, both": changed(
        lambda p, t, x: p.drift(t, 1.05 * x + 0.05), lambda p, t, x: p.diffusion(t, 1.05 * x + 0.05)
    ),
    "later": changed(lambda p, t, x: p.drift(t + 0.5, x)),
    "in one component": changed(lambda p, t, x: p.drift(t, x) + np.array([[0.7], [0.0]]) * x),
    "further square": changed(lambda p, t, x: p.drift(t, x) + 0.1 * x**2),
    "with another noise": changed(lambda p, t, x: p.drift(t, x) + 0.7 * x, lambda p, t, x: 1.5 * p.diffusion(t, x)),
    "times t": changed(lambda p, t, x: t * p.drift(t, x)),
}


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", ALIKE.values(), ids=ALIKE)
def test_of_rates_that_no_numbers_explain_nothing_is_said(scheme):
    """A mistake that is near one of a family, but is none, has no sentence."""
    assert solved_instead(scheme, generic()) == ""


def test_a_constant_drift_and_a_mean_of_the_increments_are_told_apart_by_their_numbers():
    """With additive noise both explain the rates, but only the true one with the same numbers on two equations."""
    additive = SDE(
        drift=drift,
        diffusion=lambda t, x: diffusion(0.0, np.zeros((2, 1))),
        start=[0.3, -0.2],
        noise_dim=2,
        horizon=1.0,
        traits=frozenset({"additive-noise"}),
        source="test",
    )
    constant = changed(lambda p, t, x: p.drift(t, x) + np.array([[0.3], [-0.1]]))

    assert solved_instead(constant, additive) == NAMED["further constant"][1]
    assert solved_instead(NAMED["means"][0], additive) == NAMED["means"][1]


def test_of_numbers_that_depend_on_the_equation_nothing_is_said():
    """A further drift B v where v is a number of the problem itself has other numbers on the random equation."""
    own = changed(lambda p, t, x: p.drift(t, x) + float(p.drift(0.0, p.initial(1))[0, 0]) * x)

    assert solved_instead(own, generic()) == ""
