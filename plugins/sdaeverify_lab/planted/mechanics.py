"""Schemes for mechanical equations, free and constrained, with one wrong part."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import (
    SDE,
    Array,
    Claim,
    ConstraintJacobian,
    DenseJacobian,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    Langevin,
    Step,
    hookimpl,
)
from sdaeverify_lab import Planted
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.ggl.implicit_euler_ggl import TO_ROUNDING, ImplicitEulerGGL
from sdaeverify_schemes.heun import HeunAdditive
from sdaeverify_schemes.mala import MALA, density_ratio, log_ratio
from sdaeverify_schemes.projections._old_normals import onto_constraint
from sdaeverify_schemes.projections.half_explicit_euler import BOUNDED, EVERY_H, HalfExplicitEuler

from ._other_noise import OtherNoise

# BAOAB and other schemes for an invariant law with a wrong part, and the claims of the right schemes.


@dataclass(frozen=True)
class WrongBAOAB(BAOAB):
    """BAOAB with c = e^{-gamma h} and s = sigma sqrt((1 + excess) (1 - c^2)/(2 gamma h)).

    Attributes
    ----------
    excess : float
        Relative excess of the variance of the noise.
    linear : bool
        Whether c = 1 - gamma h.
    early : bool
        Whether friction acts on the noise as well, c (p + s dW).
    last : str
        Last kick: ``new`` at the new position (right), ``stale`` at the old position, ``none`` omitted.
    """

    excess: float = 0.0
    linear: bool = False
    early: bool = False
    last: str = "new"

    name: ClassVar[str] = "planted-baoab"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state (q, p) has shape (2 n, P)."""
        n, gamma = problem.noise_dim, problem.friction
        old, p = state[:n], state[n:] + 0.5 * h * problem.force(state[:n])
        decay = 1.0 - gamma * h if self.linear else np.exp(-gamma * h)
        variance = (1.0 + self.excess) * -np.expm1(-2.0 * gamma * h) / (2.0 * gamma)
        kick = problem.strength * np.sqrt(variance / h) * noise.dW
        middle = decay * (p + kick) if self.early else decay * p + kick
        q = old + 0.5 * h * (p + middle)
        force = {"new": problem.force(q), "stale": problem.force(old), "none": np.zeros_like(q)}[self.last]
        return Step(np.concatenate([q, middle + 0.5 * h * force]))


class EulerOfOrderTwo(EulerMaruyama):
    """Euler-Maruyama that claims weak and invariant order 2."""

    name: ClassVar[str] = "planted-em-claims-weak-2"
    claims: ClassVar[tuple[Claim, ...]] = HeunAdditive.claims


class OtherNoiseHeun(OtherNoise, HeunAdditive):
    """Heun's scheme for additive noise with a changed increment."""

    name: ClassVar[str] = "planted-heun-noise"


# MALA that accepts too often or proposes from another law, and the claim of exact stationary means.


class AcceptsAll(MALA):
    """No rejection: Euler-Maruyama, smooth in its noise, with a bias of 0.035 on `ou` at h = 1/4."""

    name: ClassVar[str] = "planted-mala-accepts-all"
    discontinuous_in_noise: ClassVar[bool] = False

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        return Step(problem.euler(t, state, h, noise))


class WithoutProposal(MALA):
    """Acceptance by the ratio of densities alone, as for a symmetric proposal."""

    name: ClassVar[str] = "planted-mala-without-proposal"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        y = problem.euler(t, state, h, noise)
        return Step(np.where(np.log(noise.uniform(h)) < density_ratio(problem, t, state, y), y, state))


class TooWide(MALA):
    """A proposal with a tenth too much variance, accepted as the right one: E x^2 is 0.023 too large on `ou`."""

    name: ClassVar[str] = "planted-mala-too-wide"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        kick = np.sqrt(1.1) * problem.diffused(t, state, noise.dW)
        y = state + h * problem.drift(t, state) + kick
        return Step(np.where(np.log(noise.uniform(h)) < log_ratio(problem, t, h, state, y), y, state))


# Parts of the half-explicit step.


def _kick(problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, dw: Array) -> Array:
    """Return M^{-1} (h a + B dw)."""
    r, v, _ = state
    return problem.inverse_mass(h * problem.force(t, r, v) + problem.diffused(t, r, v, dw))


def _multiplier(problem: HolonomicSDAE, r: Array, old: ConstraintJacobian, x: Array) -> Array:
    """Return lambda with Dg(r) (x + M^{-1} grad g(r_0) lambda) = 0, for the linearisation `old` at r_0."""
    J = problem.linearised(r)
    return -J.gram(old).solve(J.times(x))


# The half-explicit scheme without one of its parts, and the claims of the whole scheme.


@dataclass(frozen=True)
class FreeHalfExplicit(HalfExplicitEuler):
    """The scheme without truncation."""

    truncation: str | float = "none"


@dataclass(frozen=True)
class WrongHalfExplicit(FreeHalfExplicit):
    """The scheme without truncation and with one wrong part.

    Attributes
    ----------
    position : str
        Direction of the position's projection: the old ``normal`` (right), a fixed ``axis``, or none, ``free``. If
        there is no point along the axis, the position stays, without being reported as failed.
    velocity : str
        Tangent space of the velocity's projection: ``new`` (right), ``old``, or none, ``free``.
    strength : float
        Factor of dw.
    """

    position: str = "normal"
    velocity: str = "new"
    strength: float = 1.0

    name: ClassVar[str] = "planted-half-explicit"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old = problem.linearised(r)
        y, failed = r + h * v, np.zeros(r.shape[-1], dtype=bool)
        if self.position != "free":
            new = onto_constraint(problem, y, old if self.position == "normal" else upright(problem.dg(r)))
            y, failed = np.where(new.found, new.r, r), ~new.found if self.position == "normal" else failed
        x = v + _kick(problem, state, t, h, self.strength * noise.dW)
        if self.velocity == "free":
            return Step(HolonomicState(y, np.where(failed, v, x), mu), failed)
        lam = _multiplier(problem, y if self.velocity == "new" else r, old, x)
        moved = x + problem.push(old, lam)
        return Step(HolonomicState(y, np.where(failed, v, moved), np.where(failed, mu, mu + lam)), failed)


@dataclass(frozen=True)
class AlongAxis(WrongHalfExplicit):
    """The position is projected along the last axis, and cannot pass points where that is tangential.

    Single steps do not show the error. The scheme has no claim about the invariant law, because a chain moves between
    the sides too rarely to decide it.
    """

    position: str = "axis"

    name: ClassVar[str] = "planted-half-explicit-axis"
    claims: ClassVar[tuple[Claim, ...]] = tuple(c for c in HalfExplicitEuler.claims if c.measure != "invariant")


class NoProjection(EulerMaruyama):
    """Euler-Maruyama for the inherent SDE with the claims of a projected scheme."""

    name: ClassVar[str] = "planted-em-inherent"
    claims: ClassVar[tuple[Claim, ...]] = HalfExplicitEuler.claims


def upright(normals: Array) -> DenseJacobian:
    """Return the last axis, oriented like the normals of shape (m, n, P), as a Jacobian."""
    axes = np.zeros_like(normals)
    axes[:, -1] = np.copysign(1.0, normals[:, -1])
    return DenseJacobian(axes)


# The half-explicit scheme with all claims of its theory, without the part that ensures them.


class Untruncated(FreeHalfExplicit):
    """Without truncation, energy grows until steps have no root."""

    name: ClassVar[str] = "planted-half-explicit-untruncated"

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims of a root for every h, and of bounded moments."""
        return EVERY_H, BOUNDED


class MultiplierOutput(FreeHalfExplicit):
    """Outputs the multiplier of h a + B dw without the Coriolis term, while mu accumulates the right one."""

    name: ClassVar[str] = "planted-half-explicit-multiplier-output"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result, J = super().step(problem, state, t, h, noise), problem.linearised(state.r)
        coriolis = -J.gram(J).solve(problem.d2g(state.r, state.v, state.v))
        return result._replace(outputs={**result.outputs, "lambda": result.outputs["lambda"] - h * coriolis})


# The half-explicit scheme with another multiplier.


class MultiplierSign(FreeHalfExplicit):
    """mu+ = mu - lambda."""

    name: ClassVar[str] = "planted-half-explicit-multiplier-sign"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        return result._replace(state=result.state._replace(mu=2.0 * state.mu - result.state.mu))


class WithoutCoriolis(FreeHalfExplicit):
    """The multiplier of h a + B dw without the Coriolis term D^2 g(v, v) acts before v is projected."""

    name: ClassVar[str] = "planted-half-explicit-without-coriolis"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old = problem.linearised(r)
        new = onto_constraint(problem, r + h * v, old)
        change = _kick(problem, state, t, h, noise.dW)
        first = _multiplier(problem, r, old, change)
        x = v + change + problem.push(old, first)
        lam = _multiplier(problem, new.r, old, x)
        return Step(HolonomicState(new.r, x + problem.push(old, lam), mu + first + lam), ~new.found)


# The implicit Euler scheme in GGL form with one wrong part, and the claims of the right scheme.


@dataclass(frozen=True)
class WrongImplicitEuler(ImplicitEulerGGL):
    """The scheme with wrong data in its equations, or with a wrong use of their solution.

    Attributes
    ----------
    noise_at : str
        State in B dw: ``old`` (right), or ``new``, computed first with the old state.
    force : float
        Fraction of h a that acts; the rest is subtracted at the old state.
    velocity : str
        ``solved`` (right), or ``quotient`` of the displacement and h, which violates the hidden constraint.
    multiplier : float
        Factor of h lambda in mu.
    """

    noise_at: str = "old"
    force: float = 1.0
    velocity: str = "solved"
    multiplier: float = 1.0

    name: ClassVar[str] = "planted-implicit-euler-ggl"

    @property
    def promises(self) -> tuple[Claim, ...]:
        """All claims regardless of the tolerance, except that on the invariant law, whose chains take minutes."""
        return (*(claim for claim in self.claims if claim.measure != "invariant"), TO_ROUNDING)

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        step = super().step(problem, state, t, h, noise)
        new = step.state._replace(mu=state.mu + self.multiplier * (step.state.mu - state.mu))
        if self.velocity == "quotient":
            new = new._replace(v=(new.r - state.r) / h)
        return step._replace(state=new)

    def _kick(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Array:
        r, v, _ = state
        at = r, v
        if self.noise_at == "new":
            first = ImplicitEulerGGL().step(problem, state, t, h, noise).state
            at = first.r, first.v
        return problem.diffused(t, *at, noise.dW) - (1.0 - self.force) * h * problem.force(t, r, v)


BUGS = [
    Planted("BAOAB: c = 1 - gamma h", WrongBAOAB(linear=True), "angle-pendulum"),
    Planted("BAOAB: variance +5 %", WrongBAOAB(0.05), "angle-pendulum"),
    Planted("BAOAB: variance +1 %", WrongBAOAB(0.01), "angle-pendulum"),
    Planted("BAOAB: missing last kick", WrongBAOAB(last="none"), "angle-pendulum"),
    Planted("BAOAB: stale force", WrongBAOAB(last="stale"), "angle-pendulum"),
    Planted("BAOAB: friction on the noise", WrongBAOAB(early=True), "angle-pendulum"),
    Planted("EM: weak and invariant order 2 claimed", EulerOfOrderTwo(), "angle-pendulum"),
    Planted("Heun: noise variance +1 %", OtherNoiseHeun("variance + 1 %"), "angle-pendulum"),
    Planted("MALA: without rejection", AcceptsAll(), "ou"),
    Planted("MALA: without rejection, where it diverges", AcceptsAll(), "double-well"),
    Planted("MALA: a tenth too much variance in the proposal", TooWide(), "ou"),
    Planted("MALA: the proposal's density left out", WithoutProposal(), "ou"),
    Planted("pendulum: velocity constraint dropped", WrongHalfExplicit(velocity="free"), "damped-pendulum"),
    Planted("pendulum: velocity onto the old tangent space", WrongHalfExplicit(velocity="old"), "damped-pendulum"),
    Planted("pendulum: position projection dropped", WrongHalfExplicit(position="free"), "damped-pendulum"),
    Planted("pendulum: no projection", NoProjection(), "damped-pendulum"),
    Planted("pendulum: variance +1 %", WrongHalfExplicit(strength=1.004987562112089), "damped-pendulum"),
    Planted("pendulum: position projected along a fixed axis", AlongAxis(), "damped-pendulum[theta_0=2.2,horizon=2]"),
    Planted("pendulum: truncation dropped", Untruncated(), "pendulum[omega_0=5,horizon=1]"),
    Planted("pendulum: multiplier output without Coriolis term", MultiplierOutput(), "damped-pendulum"),
    Planted("pendulum: multiplier sign", MultiplierSign(), "damped-pendulum"),
    Planted(
        "pendulum: multiplier without Coriolis term, velocity projected",
        WithoutCoriolis(),
        "damped-pendulum",
        equivalent="the projection of the velocity supplies the term that the multiplier lacks",
    ),
    Planted("implicit Euler: half of the force", WrongImplicitEuler(force=0.5), "damped-pendulum"),
    Planted(
        "implicit Euler: velocity from positions, hidden constraint dropped",
        WrongImplicitEuler(velocity="quotient"),
        "damped-pendulum",
    ),
    Planted("implicit Euler: multiplier sign", WrongImplicitEuler(multiplier=-1.0), "damped-pendulum"),
    Planted("implicit Euler: Newton's method ended early", WrongImplicitEuler(tolerance=0.001), "damped-pendulum"),
    Planted(
        "implicit Euler: noise at the new velocity", WrongImplicitEuler(noise_at="new"), "pendulum-velocity-noise"
    ),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
