"""The explicit expansion of the uniformly accurate step."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, ConstrainedLangevin, ConstraintGeometry, Increment, Scheme, Step, hookimpl

from ._langevin_noise import LangevinScheme
from ._penalty_integrals import PenaltyIntegrals

PENALISED = frozenset({"unconstrained"})


@dataclass(frozen=True)
class UniformExpansion(LangevinScheme):
    """x+ = x + sqrt(h) A + h B: (2.2) up to h^(3/2) in the weak sense, uniformly in eps.

    On a path the two differ by terms of size h and mean 0; for eps -> 0 this one leaves the manifold.

    With P = g G^{-1} g^T, c = G^{-1} zeta, w = g c, s^2 = (eps/2h) (1 - e^2), e = exp(-h/eps), omega = 1 - e,

        sqrt(h) A = sqrt(h) sigma xi - omega w + sqrt(h) sigma (s - 1) P xi,
        h B = h f + (eps omega - h) [P f + (sigma^2/2) g G^{-1} div g]
              + (sigma^2/4) [h s^2 grad ln det G + (eps/2) omega^2 P grad ln det G]
              + (omega^2/2) [g'(w) c - P g'(w) c - g G^{-1} g'(w)^T w] + (sigma^2/2) h (1 - s^2) g G^{-1} tau,

    tau_k = tr(H_k P): the last term is the sum of two printed terms.
    """

    name: ClassVar[str] = "uniform-expansion"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, when=PENALISED, source="Laurent 2022, Proposition 3.3, for fixed eps"),
        Claim(measure="invariant", value=1.0, when=PENALISED, source="the weak order at least"),
        Claim(
            measure="strong",
            value=1.0,
            when=PENALISED,
            source="for fixed eps: Euler-Maruyama up to terms of size h^(3/2) and mean 0, or h^2; additive noise",
        ),
    )
    source: ClassVar[str] = "Laurent 2022, Proposition 3.3"

    def step(self, problem: ConstrainedLangevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        at, f, over = problem.near(state), problem.drift(state), PenaltyIntegrals.over(h, problem.eps)
        bent = 0.5 * problem.strength**2 * over.second * at.fixman + over.omega**2 * at.quadratic
        free = problem.strength * noise.dW + h * f + 0.5 * bent
        return Step(state + free + at.J.transposed(at.gram.solve(_normal(at, f, noise.dW, h))))


def _normal(at: ConstraintGeometry, f: Array, dW: Array, h: float) -> Array:
    """Return r of the part g G^{-1} r of a step that acts along the normals alone, shape (q, P)."""
    problem, over = at.problem, PenaltyIntegrals.over(h, at.problem.eps)
    variance, omega, lag = problem.strength**2, over.omega, over.first - h
    spread = problem.strength * (np.sqrt(over.second / h) - 1.0)
    turned = np.einsum("kdp,dp->kp", problem.turned(at.x, at.relaxation), at.relaxation)
    moved = spread * dW + lag * f + 0.125 * variance * omega * over.first * at.fixman
    along = at.J.times(moved - 0.5 * omega**2 * at.quadratic)
    traces = lag * at.divergence + (h - over.second) * at.normal_traces
    return np.asarray(along - omega * at.zeta - 0.5 * omega**2 * turned + 0.5 * variance * traces)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [UniformExpansion()]
