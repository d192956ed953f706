"""Schemes for constrained mechanics, for delays and for equations of index 1."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from right.case import EULER, Case, Twin, order
from sdaeverify import (
    SDE,
    Array,
    Claim,
    ConstraintJacobian,
    DelaySDAE,
    DelayState,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    IndexOneSDAE,
    Mask,
    Step,
)
from sdaeverify.numerics import newton, norm, update_tolerance

ROUND_OFF = Claim(measure="drift", value="round-off", source="tests/right")


def onto(problem: HolonomicSDAE | SDE, y: Array, old: ConstraintJacobian) -> tuple[Array, Array, Mask]:
    """Return r = y + M^{-1} grad g(r_0) kappa with g(r) = 0, kappa, and where Newton's method converged."""

    def equation(kappa: Array) -> tuple[Array, object]:
        r = y + problem.push(old, kappa)
        return problem.constraint(r), problem.linearised(r).gram(old)

    none = np.zeros_like(old.times(y))
    tolerance = update_tolerance(norm(y)) / old.size()
    root = newton(equation, none, tolerance, solver=lambda A, b: A.solve(b))
    return y + problem.push(old, root.x), root.x, root.converged


@dataclass(frozen=True)
class Mechanics(Twin):
    """A scheme for constrained mechanics; a path without a root keeps its state."""

    form: ClassVar[type] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = (*EULER, ROUND_OFF)

    def impulse(self, problem: HolonomicSDAE, t: float, state: HolonomicState, h: float, dW: Array) -> Array:
        """Return M^{-1} (h a + B dW)."""
        r, v, _ = state
        return problem.inverse_mass(h * problem.force(t, r, v) + problem.diffused(t, r, v, dW))

    def held(self, state: HolonomicState, end: tuple[Array, Array, Array], found: Mask) -> Step:
        """Return the step that keeps the state where there is no root."""
        kept = (np.where(found, new, old) for new, old in zip(end, state, strict=True))
        return Step(HolonomicState(*kept), ~found)


@dataclass(frozen=True)
class Shake(Mechanics):
    """w = v + M^{-1} (h a + B dW), r+ = r + h w + M^{-1} grad g(r) kappa, v+ tangential near w + .../h.

    Wrong with half of the correction of w in the multiplier alone.
    """

    name: ClassVar[str] = "right-shake"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old = problem.linearised(r)
        w = v + self.weight(1.0, 0.9) * self.impulse(problem, t, state, h, noise.dW)
        new, kappa, found = onto(problem, r + h * w, old)
        v_new, c = problem.tangent(problem.linearised(new), w + problem.push(old, kappa / h))
        return self.held(state, (new, v_new, mu + kappa / h + c), found)


@dataclass(frozen=True)
class Rattle(Mechanics):
    """Half of the impulse, RATTLE without force, half of it at the new position; wrong with 0.4 for the last half."""

    name: ClassVar[str] = "right-rattle"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        old, whole = problem.linearised(r), self.impulse(problem, t, state, h, noise.dW)
        w = v + 0.5 * whole
        new, kappa, found = onto(problem, r + h * w, old)
        end = w + problem.push(old, kappa / h) + self.weight(0.5, 0.4) * whole
        v_new, c = problem.tangent(problem.linearised(new), end)
        return self.held(state, (new, v_new, mu + kappa / h + c), found)


@dataclass(frozen=True)
class NewNormals(Mechanics):
    """r+ near r + h v along old normals, v+ near v + M^{-1} (h a + B dW) along new ones; wrong with h v/2."""

    name: ClassVar[str] = "right-new-normals"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        new, _, found = onto(problem, r + self.weight(1.0, 0.9) * h * v, problem.linearised(r))
        J = problem.linearised(new)
        v_new, lam = problem.tangent(J, v + self.impulse(problem, t, state, h, noise.dW))
        return self.held(state, (new, v_new, mu + lam), found)


@dataclass(frozen=True)
class ProjectedMilstein(Twin):
    """Euler's step for an SDE with an invariant, then onto the manifold along the old normals; wrong with 0.9 B."""

    name: ClassVar[str] = "right-old-normals"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (*EULER, ROUND_OFF)

    def refuses(self, problem: SDE) -> str:
        """Refuse problems without constraint."""
        return "" if problem.has_constraints else "there is no constraint"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        y = x + h * problem.drift(t, x) + self.weight(1.0, 0.9) * problem.diffused(t, x, noise.dW)
        new, _, found = onto(problem, y, problem.linearised(x))
        return Step(np.where(found, new, x), ~found)


@dataclass(frozen=True)
class DelayPredictor(Twin):
    """x+ = x + h [f(t, x, v, y) + f(t + h, z, w, u)]/2 + g dW, z Euler's step, w lagged; wrong with 0.4 and 0.5."""

    name: ClassVar[str] = "right-delay-predictor"
    form: ClassVar[type] = DelaySDAE
    claims: ClassVar[tuple[Claim, ...]] = (*EULER, order("strong", 1.0, "additive-noise"))

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (x, y), lag = state, problem.lag(state.x, h, noise)
        f, kick = problem.drift(t, x, lag.now, y), problem.diffused(t, x, lag.now, y, noise.dW)
        z = x + h * f + kick
        later = problem.drift(t + h, z, lag.ahead(z), solved(problem, t + h, z, lag.ahead(z), y))
        new = x + h * (0.5 * f + self.weight(0.5, 0.4) * later) + kick
        return Step(DelayState(new, solved(problem, t + h, new, lag.ahead(new), y)))


def solved(problem: DelaySDAE, t: float, x: Array, v: Array, y: Array) -> Array:
    """Return the y that solves the constraint; the given one where there is none."""
    return y if problem.constraint is None else problem.eliminated(t, x, v)


@dataclass(frozen=True)
class IndexOneEuler(Twin):
    """x+ = x + h f(t, x, y) + g(t, x, y) dW, 0 = u(t + h, x+, y+), for equations of index 1; wrong with the old y."""

    name: ClassVar[str] = "right-index-one-euler"
    form: ClassVar[type] = IndexOneSDAE
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: IndexOneSDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, y = state
        new = x + h * problem.drift(t, x, x, y) + problem.diffused(t, x, x, y, noise.dW)
        at = new if self.right else x
        return Step(DelayState(new, solved(problem, t + h, at, at, y)))


@dataclass(frozen=True)
class IndexOneTrapezoidal(Twin):
    """Heun's drift for equations of index 1, y at the predictor; wrong with the old y in the second stage."""

    name: ClassVar[str] = "right-index-one-heun"
    form: ClassVar[type] = IndexOneSDAE
    claims: ClassVar[tuple[Claim, ...]] = (*EULER, order("weak", 2.0, "additive-noise"))

    def step(self, problem: IndexOneSDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, y = state
        f, kick = problem.drift(t, x, x, y), problem.diffused(t, x, x, y, noise.dW)
        z = x + h * f + kick
        later = problem.drift(t + h, z, z, solved(problem, t + h, z, z, y) if self.right else y)
        new = x + 0.5 * h * (f + later) + kick
        return Step(DelayState(new, solved(problem, t + h, new, new, y)))


PENDULA = "damped-pendulum,driven-double-pendulum"
CASES = (
    Case(Shake, PENDULA),
    Case(Rattle, PENDULA),
    Case(NewNormals, PENDULA),
    Case(ProjectedMilstein, "sphere,circle"),
    Case(DelayPredictor, "delay-ou,delay-pair"),
    Case(IndexOneEuler, "noisy-circuit,gbm-algebraic"),
    Case(IndexOneTrapezoidal, "noisy-circuit,gbm-algebraic"),
)
