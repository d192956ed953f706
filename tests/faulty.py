"""Planted wrong schemes: each must be refuted by the check its claim names, or the verifier verifies nothing."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, HolonomicSDAE, HolonomicState, Increment, Scheme, Step
from sdaeverify.numerics import apply, apply_transposed, newton, product_transposed, solve

HALF = (Claim(measure="strong", value=0.5, source="planted"),)
ONE = (Claim(measure="strong", value=1.0, source="planted"),)
EXACT = (
    Claim(measure="strong", value=1.0, source="planted"),
    Claim(measure="drift", value="round-off", source="planted"),
)


@dataclass(frozen=True)
class MissingItoCorrection(Scheme):
    """Euler-Maruyama of the Stratonovich equation with the same coefficients."""

    name: ClassVar[str] = "missing-ito-correction"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = HALF

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        B = problem.diffusion(t, state)
        correction = 0.5 * problem.derivative_of_diffusion(t, state, B[:, 0])[:, 0]
        return Step(state + h * (problem.drift(t, state) - correction) + apply(B, noise.dW))


@dataclass(frozen=True)
class NoiseScaledByH(Scheme):
    """Euler-Maruyama with noise of size h in place of sqrt(h)."""

    name: ClassVar[str] = "noise-scaled-by-h"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = HALF

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return Step(state + h * problem.drift(t, state) + np.sqrt(h) * apply(problem.diffusion(t, state), noise.dW))


@dataclass(frozen=True)
class NoiseTooStrong(Scheme):
    """Euler-Maruyama with five per cent too much variance: converges fast, to something else."""

    name: ClassVar[str] = "noise-too-strong"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = HALF

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return Step(
            state + h * problem.drift(t, state) + np.sqrt(1.05) * apply(problem.diffusion(t, state), noise.dW)
        )


@dataclass(frozen=True)
class MilsteinSign(Scheme):
    """Milstein's scheme with its correction subtracted."""

    name: ClassVar[str] = "milstein-sign"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        B = problem.diffusion(t, state)
        correction = 0.5 * problem.derivative_of_diffusion(t, state, B[:, 0])[:, 0] * (noise.dW**2 - h)
        return Step(state + h * problem.drift(t, state) + apply(B, noise.dW) - correction)


@dataclass(frozen=True)
class FixedDirection(Scheme):
    """Half-explicit Euler that projects along a fixed axis in place of the old normal."""

    name: ClassVar[str] = "fixed-direction"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = EXACT

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        r = state.r
        axis = np.broadcast_to(np.array([[[0.0], [1.0]]]), (1, *r.shape))
        return half_explicit(problem, state, axis, t, h, noise)


@dataclass(frozen=True)
class VelocityNotProjected(Scheme):
    """Half-explicit Euler without its second half: the hidden constraint is left alone."""

    name: ClassVar[str] = "velocity-not-projected"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = EXACT

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        r, v, mu = state
        step = half_explicit(problem, state, problem.dg(r), t, h, noise)
        x = v + h * problem.force(t, r, v) + apply(problem.diffusion(t, r, v), noise.dW)
        return Step(HolonomicState(step.state.r, x, mu), step.failed)


def half_explicit(
    problem: HolonomicSDAE, state: HolonomicState, direction: Array, t: float, h: float, noise: Increment
) -> Step:
    """Make a half-explicit step without truncation along given directions, shape (m, n, P), for unit mass."""
    r, v, mu = state
    y = r + h * v

    def linearised(kappa: Array) -> tuple[Array, Array]:
        x = y + apply_transposed(direction, kappa)
        return problem.constraint(x), product_transposed(problem.dg(x), direction)

    root = newton(linearised, np.zeros_like(mu), 1e-9)
    r_new = y + apply_transposed(direction, root.x)
    x = v + h * problem.force(t, r, v) + apply(problem.diffusion(t, r, v), noise.dW)
    lam = -solve(product_transposed(problem.dg(r_new), direction), apply(problem.dg(r_new), x))
    return Step(HolonomicState(r_new, x + apply_transposed(direction, lam), mu + lam), ~root.converged)
