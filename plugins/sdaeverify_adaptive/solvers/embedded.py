"""Heun and Milstein with an embedded estimate of their error and a PI controller."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, hookimpl
from sdaeverify.numerics import apply
from sdaeverify_schemes.heun import stratonovich

from ..contract import Adaptive
from ..marching import Marching, Stretch, Tried

COMMUTATIVE = frozenset({"commutative-noise"})
RATE = "measured; no theorem is known of a PI controller's rate"
LIMIT = "the limit by Doss 1977 and Sussmann 1978: the solution is continuous in W"


class HeunPI(Marching):
    """Heun's scheme in Stratonovich's sense; the error estimate is its difference from an Euler step.

    y = x + h F + B dW,   x+ = x + (h/2) (F + F(y)) + (1/2) (B + B(y)) dW,   estimate x+ - y.
    """

    name: ClassVar[str] = "heun-pi"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="tolerance", value=0.5, when=COMMUTATIVE, source=f"{LIMIT}; the rate is {RATE}"),
        Claim(measure="tolerance-steps", value=0.9, when=COMMUTATIVE, source=RATE),
        Claim(
            measure="tolerance-law", value="unbiased", bound=0.05, quantities=("x",), when=COMMUTATIVE, source=RATE
        ),
    )
    source: ClassVar[str] = "Ruemelin 1982 for the step; Ilie, Jackson & Enright 2015 for such controllers"

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step and its error estimate."""
        return heun(problem, step)


class MilsteinPI(Marching):
    """Milstein's scheme; the error estimate is its difference from an Euler step, plus that of two drifts.

    x+ = x + h f + B dW + (1/2) DB B (dW^2 - h),   estimate (1/2) |DB B| |dW^2 - h| + (h/2) |f(x+) - f(x)|.
    """

    name: ClassVar[str] = "milstein-pi"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="tolerance", value=0.5, when=COMMUTATIVE, source=f"{LIMIT}; the rate is {RATE}"),
        Claim(measure="tolerance-steps", value=0.9, when=COMMUTATIVE, source=RATE),
    )
    source: ClassVar[str] = "Milstein 1974 for the step"

    def refuses(self, problem: SDE) -> str:
        """Refuse more than one Brownian motion, and all problems refused by `Marching`."""
        if problem.noise_dim > 1:
            return f"noise in {problem.noise_dim} dimensions is not scalar"
        return super().refuses(problem)

    def attempt(self, problem: SDE, step: Stretch) -> Tried:
        """Compute a step and its error estimate."""
        euler, correction = milstein(problem, step)
        after = euler + correction
        drifts = at(problem.drift, step.t + step.h, after) - at(problem.drift, step.t, step.x)
        return Tried(after, np.abs(correction) + 0.5 * step.h * np.abs(drifts))


def heun(problem: SDE, step: Stretch) -> Tried:
    """Return a step of Heun's scheme, and its difference from the embedded Euler step."""
    t, h, dW = step.t, step.h, step.noise.dW
    F, B = stratonovich_at(problem, t, step.x)
    kick = apply(B, dW)
    euler = step.x + h * F + kick
    G, C = stratonovich_at(problem, t + h, euler)
    error = 0.5 * (h * (G - F) + apply(C, dW) - kick)
    return Tried(euler + error, error)


def at(coefficient: Callable[..., Array], t: Array, x: Array) -> Array:
    """Evaluate a coefficient at a different time on each path; problems that do not support this are refused.

    Parameters
    ----------
    coefficient : callable, (t, x) -> ndarray
        Coefficient of the problem.
    t : ndarray, shape (P,)
        Times, one for each path.
    x : ndarray, shape (d, P)
        States at these times.
    """
    return coefficient(t, x)


def stratonovich_at(problem: SDE, t: Array, x: Array) -> tuple[Array, Array]:
    """Return the Stratonovich drift and the diffusion at a different time on each path.

    Parameters
    ----------
    problem : SDE
        Problem in Ito's sense.
    t : ndarray, shape (P,)
        Times, one for each path.
    x : ndarray, shape (d, P)
        States at these times.
    """
    return stratonovich(problem, t, x)  # type: ignore[arg-type] # as `at`


def milstein(problem: SDE, step: Stretch) -> tuple[Array, Array]:
    """Return an Euler step for scalar noise, and the Milstein correction (1/2) DB B (dW^2 - h)."""
    (dW,), x = step.noise.dW, step.x
    B = np.broadcast_to(at(problem.diffusion, step.t, x)[:, 0], x.shape)
    turned = problem.derivative_of_diffusion(step.t, x, B)[:, 0]  # type: ignore[arg-type] # as `at`
    return x + step.h * at(problem.drift, step.t, x) + B * dW, 0.5 * turned * (dW**2 - step.h)


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register both solvers."""
    return [HeunPI(), MilsteinPI()]
