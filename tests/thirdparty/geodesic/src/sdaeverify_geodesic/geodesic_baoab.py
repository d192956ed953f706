"""Geodesic BAOAB: the splitting scheme BAOAB whose moves follow the constraint's manifold."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import (
    Array,
    Claim,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    Mask,
    ParameterError,
    Scheme,
    Step,
    hookimpl,
)
from sdaeverify.numerics import newton, norm

from ._canonical import canonical

PAPER = "Leimkuhler & Matthews 2016"
# Newton's last update as a part of the position: it converges quadratically, what is left is rounding.
RELATIVE = 1e-9


@dataclass(frozen=True)
class GeodesicBAOAB(Scheme):
    """Half a kick, half a move, friction and noise, half a move, half a kick, each of them on the manifold g = 0.

    For dr = v dt, M dv = (F(r) - gamma M v) dt + B(r) dw + grad g dmu, with c = e^{-gamma h} and the projection
    Q(r) = Id - M^{-1} grad g G_M^{-1} Dg onto the tangent space,

        B:  v <- v + (h/2) Q(r) M^{-1} F(r)
        A:  r' = r + tau v + M^{-1} grad g(r) kappa,  g(r') = 0,     v' = Q(r') (r' - r)/tau,   tau = h/(2 moves),
            so many times: RATTLE for the motion without force, a geodesic
        O:  v <- c v + sqrt((1 - c^2)/(2 gamma h)) Q(r) M^{-1} B(r) dw.

    Every part solves its equation exactly in law or, A, up to terms of size tau^3, and the order of the parts is
    symmetric. So the generator of the scheme is that of the equation up to terms of size h^2: weak order 2. On one
    path the noise enters in the middle of the step: the defect is of size h^(3/2), its mean of size h^2, and the
    strong order is 1. mu is the sum of what the projections take; of the noise it takes all of dw, as friction acts
    on v alone. A path on which Newton's method finds no root keeps its state and counts as failed.

    Attributes
    ----------
    moves : int
        Steps of RATTLE in each half of the move.
    """

    moves: int = 1

    name: ClassVar[str] = "geodesic-baoab"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source="local errors of size h^(3/2), and h^2 in the mean"),
        Claim(measure="weak", value=2.0, source=f"{PAPER}: a symmetric splitting"),
        Claim(measure="invariant", value=2.0, source=f"{PAPER}: a symmetric splitting"),
        Claim(measure="drift", value="round-off", source=f"{PAPER}: positions and velocities are projected"),
    )
    source: ClassVar[str] = PAPER

    def __post_init__(self) -> None:
        if self.moves < 1:
            raise ParameterError(f"moves must be at least 1, got {self.moves!r}")

    def refuses(self, problem: HolonomicSDAE) -> str:
        """Refuse what is not canonical Langevin dynamics."""
        return canonical(problem).reason

    def prepare(self, problem: HolonomicSDAE, h: float) -> "Splitting":
        """Return the step."""
        return Splitting(problem, h, canonical(problem).gamma, self.moves)


@dataclass(frozen=True, eq=False)
class Splitting:
    """The step for one problem and step size.

    Attributes
    ----------
    problem : HolonomicSDAE
    h, gamma : float
    moves : int
    """

    problem: HolonomicSDAE
    h: float
    gamma: float
    moves: int

    def __call__(self, state: HolonomicState, t: float, noise: Increment) -> Step:
        """Make one step."""
        middle, found = self._moved(self._kicked(state))
        end, found_too = self._moved(self._thermalised(middle, t, noise.dW))
        end, failed = self._kicked(end), ~(found & found_too)
        kept = (np.where(failed, old, new) for old, new in zip(state, end, strict=True))
        return Step(HolonomicState(*kept), failed)

    def _kicked(self, state: HolonomicState) -> HolonomicState:
        r, v, mu = state
        a = np.broadcast_to(self.problem.force(0.0, r, 0.0 * v), r.shape)
        kick, c = self._projected(r, 0.5 * self.h * a)
        return HolonomicState(r, v + kick, mu + c)

    def _thermalised(self, state: HolonomicState, t: float, dW: Array) -> HolonomicState:
        (r, v, mu), gamma = state, self.gamma
        # (1 - c^2)/(2 gamma), which is h without friction.
        variance = -np.expm1(-2.0 * gamma * self.h) / (2.0 * gamma) if gamma else self.h
        kick, c = self._projected(r, self.problem.diffused(t, r, 0.0 * v, dW))
        return HolonomicState(r, np.exp(-gamma * self.h) * v + np.sqrt(variance / self.h) * kick, mu + c)

    def _projected(self, r: Array, impulse: Array) -> tuple[Array, Array]:
        return self.problem.tangent(self.problem.linearised(r), self.problem.inverse_mass(impulse))

    def _moved(self, state: HolonomicState) -> tuple[HolonomicState, Mask]:
        found = np.ones(state.r.shape[1], dtype=bool)
        for _ in range(self.moves):
            state, reached = self._rattled(state, 0.5 * self.h / self.moves)
            found &= reached
        return state, found

    def _rattled(self, state: HolonomicState, tau: float) -> tuple[HolonomicState, Mask]:
        (r, v, mu), problem = state, self.problem
        old, free = problem.linearised(r), r + tau * v

        def defect(kappa: Array) -> tuple[Array, object]:
            z = free + problem.push(old, kappa)
            return problem.constraint(z), problem.linearised(z).gram(old)

        tolerance = RELATIVE * norm(r) / old.size()
        root = newton(defect, np.zeros((problem.constraints, r.shape[1])), tolerance, solver=lambda A, b: A.solve(b))
        r_new = free + problem.push(old, root.x)
        new = problem.linearised(r_new)
        # Not (r' - r)/tau, whose rounding grows as tau falls.
        v_new, c = problem.tangent(new, v + problem.push(old, root.x / tau))
        reached = root.converged & new.gram(old).positive()
        return HolonomicState(r_new, v_new, mu + root.x / tau + c), reached


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [GeodesicBAOAB()]
