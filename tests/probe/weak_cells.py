"""Problems, correct schemes and planted wrong ones for the tests of local weak orders, each a few lines."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np

from facade import SemigroupReference, WeakOrder, local_weak, weak_order, weak_reference
from sdaeverify import GAUSSIAN, SDE, THREE_POINT, TWO_POINT, Array, Increment, Law, Scheme, Step
from sdaeverify.numerics import apply

Formula = Callable[..., Array]
A, B = 0.5, 0.6
SIGMA, GAMMA = 0.7, 0.5
# The four values +-sqrt(2) and 0 twice: variance 1, fourth moment 2 in place of 3.
FLAT = Law("flat", lambda x: x, (-(2.0**0.5), 0.0, 2.0**0.5), (0.25, 0.5, 0.25))


def scheme(formula: Formula, law: Law = GAUSSIAN, noise: tuple[str, ...] = ("dW",), **parameters: Any) -> Scheme:
    """Return a scheme for SDEs that steps by a formula (problem, x, t, h, noise) -> x+."""

    def step(self: Scheme, problem: SDE, x: Array, t: float, h: float, increment: Increment) -> Step:
        return Step(formula(problem, x, t, h, increment, **parameters))

    members = {"name": formula.__name__, "form": SDE, "law": law, "noise": frozenset(noise), "step": step}
    return type("Probed", (Scheme,), members)()


def equation(drift: Any, diffusion: Any, start: list[float], **more: Any) -> SDE:
    """Return an SDE of unit horizon."""
    settings: Mapping[str, Any] = {"horizon": 1.0, "noise_dim": 1, "source": "test", **more}
    return SDE(drift=drift, diffusion=diffusion, start=start, **settings)


def project(x: Array) -> Array:
    """Return Id - x x^T/|x|^2, shape (d, d, P)."""
    return np.eye(len(x))[..., None] - x[:, None] * x[None] / (x * x).sum(axis=0)


def constant(*rows: list[float]) -> Any:
    """Return a diffusion that is the same everywhere."""
    return lambda t, x: np.array(rows)[..., None]


LEFT, RIGHT = np.array([[0.3, 0.5], [0.0, 0.2]]), np.array([[0.1, 0.0], [0.4, 0.3]])
PROBLEMS: Mapping[str, SDE] = {
    "gbm": equation(lambda t, x: A * x, lambda t, x: B * x[:, None], [1.0]),
    "ou": equation(lambda t, x: -x, constant([SIGMA]), [1.0]),
    "forced": equation(lambda t, x: np.sin(3.0 * t) - x - x**3, constant([SIGMA]), [0.6]),
    "pendulum": equation(
        lambda t, x: np.stack([x[1], -np.sin(x[0]) - GAMMA * x[1]]), constant([0.0], [SIGMA]), [0.5, 0.5]
    ),
    "sphere": equation(
        lambda t, x: -x / (x * x).sum(axis=0), lambda t, x: project(x), [0.6, 0.0, 0.8], noise_dim=3,
        constraint=lambda x: 0.5 * (1.0 - (x * x).sum(axis=0))[None],
    ),
    "two noises": equation(
        lambda t, x: -0.5 * x, lambda t, x: np.stack([LEFT @ x, RIGHT @ x], axis=1), [1.0, 0.5], noise_dim=2
    ),
}  # fmt: skip


@cache
def reference(view: SDE, steps: tuple[tuple[float, float], ...], *, further: bool = False) -> SemigroupReference:
    """Return what the equation of a problem says, once."""
    return weak_reference(view, steps, further=further)


def order(of: Scheme, name: str) -> WeakOrder:
    """Return the local weak order of a scheme on a problem."""
    return weak_order(local_weak(of, PROBLEMS[name], reference))


def euler(p: SDE, x: Array, t: float, h: float, n: Increment, *, variance: float = 1.0, drift: float = 1.0) -> Array:
    return x + drift * h * p.drift(t, x) + np.sqrt(variance) * apply(p.diffusion(t, x), n.dW)


def balanced(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    return x + (euler(p, x, t, h, n) - x) / (1.0 + np.abs(n.dW).sum(axis=0))


def exact_gbm(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    return x * np.exp((A - 0.5 * B * B) * h + B * n.dW)


def exact_ou(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    return np.exp(-h) * x + SIGMA * np.sqrt(-np.expm1(-2.0 * h) / (2.0 * h)) * n.dW


def projected(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    y = euler(p, x, t, h, n)
    return y / np.sqrt((y * y).sum(axis=0))


def heun(p: SDE, x: Array, t: float, h: float, n: Increment, *, variance: float = 1.0) -> Array:
    kick, f = np.sqrt(variance) * apply(p.diffusion(t, x), n.dW), p.drift(t, x)
    return x + 0.5 * h * (f + p.drift(t + h, x + h * f + kick)) + kick


def platen(p: SDE, x: Array, t: float, h: float, n: Increment) -> Array:
    f, b = p.drift(t, x), p.diffusion(t, x)[:, 0]
    up, down = (p.diffusion(t, x + h * f + s * np.sqrt(h) * b)[:, 0] for s in (1.0, -1.0))
    later = p.drift(t + h, x + h * f + b * n.dW)
    kick = (up + down + 2.0 * b) * n.dW + (up - down) * (n.dW**2 - h) / np.sqrt(h)
    return x + 0.5 * h * (f + later) + 0.25 * kick


def baoab(p: SDE, x: Array, t: float, h: float, n: Increment, *, variance: float = 1.0) -> Array:
    q, v = x
    c = np.exp(-GAMMA * h)
    v = v - 0.5 * h * np.sin(q)
    w = c * v + SIGMA * np.sqrt(variance * (1.0 - c * c) / (2.0 * GAMMA * h)) * n.dW[0]
    end = q + 0.5 * h * (v + w)
    return np.stack([end, w - 0.5 * h * np.sin(end)])


# Scheme, problem and weak order.
CORRECT: Mapping[str, tuple[Scheme, str, float]] = {
    "Euler-Maruyama": (scheme(euler), "gbm", 1.0),
    "Euler-Maruyama, two noises that do not commute": (scheme(euler), "two noises", 1.0),
    "Euler-Maruyama, two-point noise": (scheme(euler, TWO_POINT), "two noises", 1.0),
    "exact": (scheme(exact_gbm), "gbm", np.inf),
    "exact in law": (scheme(exact_ou), "ou", np.inf),
    "balanced, |dW|": (scheme(balanced), "gbm", 0.5),
    "projected Euler-Maruyama, sphere": (scheme(projected), "sphere", 1.0),
    "Heun, additive noise": (scheme(heun), "forced", 2.0),
    "Platen": (scheme(platen, THREE_POINT), "gbm", 2.0),
    "BAOAB": (scheme(baoab), "pendulum", 2.0),
}

# Scheme, problem, what it claims and whether it has no order at all.
PLANTED: Mapping[str, tuple[Scheme, str, float, bool]] = {
    "Euler-Maruyama: variance + 1e-4": (scheme(euler, variance=1.0001), "gbm", 1.0, True),
    "Euler-Maruyama: variance - 1e-4": (scheme(euler, variance=0.9999), "gbm", 1.0, True),
    "balanced, |dW|": (scheme(balanced), "gbm", 1.0, False),
    "Heun: variance + 1e-7": (scheme(heun, variance=1.0 + 1e-7), "forced", 2.0, True),
    "Heun: variance - 1e-7": (scheme(heun, variance=1.0 - 1e-7), "forced", 2.0, True),
    "Platen: wrong fourth moment": (scheme(platen, FLAT), "gbm", 2.0, False),
    "BAOAB: variance + 1 %": (scheme(baoab, variance=1.01), "pendulum", 2.0, True),
}
