"""Penalised and constrained Langevin dynamics against dense differences of their definitions."""

import re
from functools import partial

import numpy as np
import pytest

from forms.refusing import refusal
from sdaeverify import Array, ConstrainedLangevin

SIGMA, STEP = 0.8, 6e-6
# Central differences of functions of order one, their rounding and their third derivatives.
DIFFERENCE = 1e-7
POINTS = np.array([[1.02, 0.75], [0.1, -0.6], [-0.2, 0.3], [0.4, 0.1]])


def zeta(q: int, x: Array) -> Array:
    """Return the first q of three constraints without any symmetry, zero at (1, 0, 0, 0)."""
    both = [0.5 * ((x * x).sum(axis=0) - 1.0) + 0.3 * x[0] * x[1], x[2] + 0.7 * x[0] * x[1] + 0.2 * x[3] ** 3]
    return np.stack([*both, np.sin(x[3]) + 0.4 * x[1] * x[2]])[:q]


def make(q: int = 1, eps: float = 0.1, **changes) -> ConstrainedLangevin:
    given = {
        "drift": lambda x: np.cos(x[::-1]) - x,
        "strength": SIGMA,
        "eps": eps,
        "constraint": partial(zeta, q),
        "start": [1.0, 0.0, 0.0, 0.0],
        "horizon": 1.0,
        "source": "made up",
    }
    return ConstrainedLangevin(**{**given, **changes})


def derivative(f, x: Array, y: Array) -> Array:
    return (f(x + STEP * y) - f(x - STEP * y)) / (2.0 * STEP)


def columns(f, x: Array) -> Array:
    """Return the derivatives of f along all axes, axis first."""
    return np.stack([derivative(f, x, unit[:, None]) for unit in np.eye(len(x))])


@pytest.mark.parametrize("q", [1, 2, 3])
def test_second_derivatives(q):
    """The quadratic term, the traces and the traces over the normal space follow from dense Hessians."""
    problem = make(q)
    at = problem.near(POINTS)
    hessians = np.moveaxis(columns(problem.dg, POINTS), 0, 1)
    g = problem.dg(POINTS)
    w = np.einsum("kip,kp->ip", g, at.share)
    assert np.allclose(at.relaxation, w, rtol=1e-12)
    assert np.allclose(at.quadratic, np.einsum("kp,kijp,jp->ip", at.share, hessians, w), atol=DIFFERENCE)
    assert np.allclose(at.divergence, np.einsum("kiip->kp", hessians), atol=DIFFERENCE)
    P = np.einsum("kip,kjp->ijp", g, at.dual)
    assert np.allclose(at.normal_traces, np.einsum("kijp,jip->kp", hessians, P), atol=DIFFERENCE)


def quadric(x: Array, axes: Array) -> Array:
    return 0.5 * np.einsum("kij,ip,jp->kp", axes, x, x) - 0.5


AXES = np.stack(
    [np.eye(3) + 0.3 * np.diag([0.0, 1.0, -1.0]), np.array([[1.0, 0.4, 0.0], [0.4, 2.0, 0.0], [0.0, 0.0, 0.5]])]
)


def test_constant_hessians_closed_contractions_and_complex_steps_agree():
    """Three ways to give second derivatives are one problem."""
    common = {"constraint": partial(quadric, axes=AXES), "start": [1.0, 0.0, 0.0], "drift": lambda x: -x}
    ways = [
        make(**common),
        make(**common, hessians=AXES),
        make(
            **common,
            second=lambda x, A: np.einsum("kij,jkp->ip", AXES, A),
            laplacians=lambda x: np.einsum("kii->k", AXES)[:, None] + 0.0 * x[:1],
        ),
    ]
    x = np.array([[0.9], [0.2], [-0.4]])
    for name in ("fixman", "quadratic", "divergence", "normal_traces"):
        first, *others = (getattr(way.near(x), name) for way in ways)
        assert all(np.allclose(first, other, rtol=1e-9, atol=1e-12) for other in others)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"eps": -1.0}, "eps must be finite and not negative, got -1.0"),
        ({"start": [1.1, 0.0, 0.0, 0.0]}, "start violates constraint = 0"),
        ({"constraint": lambda x: np.stack([x[1], 2.0 * x[1]])}, "does not have full rank"),
        ({"constraint": lambda x: x[0]}, "components, expected between 1 and 3|returned shape"),
        ({"jacobian": lambda x: 1.1 * make().dg(x)}, "jacobian disagrees with a difference quotient"),
        ({"jacobian": lambda x: make().dg(x)[0]}, "jacobian.* returned shape"),
        ({"second": lambda x, A: A[:, 0]}, "second disagrees with a difference quotient"),
        ({"laplacians": lambda x: 3.0 + 0.0 * x[:1]}, "laplacians disagrees"),
        ({"hessians": np.eye(4)}, r"hessians has shape \(4, 4\), expected \(1, 4, 4\)"),
        ({"drift": lambda x: x[:2]}, "drift.* returned shape"),
    ],
)
def test_bad_input_is_named(changes, message):
    """Each mistake gives one line that says what was expected and what was given."""
    assert re.search(message, refusal(make, **changes))
