"""The explicit expansion of the uniformly accurate step."""

from dataclasses import replace
from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import Array, Claim, ConstrainedLangevin, ConstraintGeometry, Increment, Scheme, Step, hookimpl

from .._small_steps import STABLE
from ._langevin_noise import LangevinScheme
from ._penalty_integrals import PenaltyIntegrals

PENALISED = frozenset({"unconstrained"})


class ExpansionWeights(NamedTuple):
    """Coefficients of the terms of a step.

    Attributes
    ----------
    fixman, quadratic : float
        Coefficients of grad ln det G, and of g'(w) c - P g'(w) c.
    noise, drift, normal_fixman : float
        Coefficients of P sqrt(h) xi, P f and P grad ln det G.
    zeta, turned : float
        Coefficients of -g G^{-1} zeta and -g G^{-1} g'(w)^T w.
    divergence, traces : float
        Coefficients of g G^{-1} div g and g G^{-1} tau.
    """

    fixman: float
    quadratic: float
    noise: float
    drift: float
    normal_fixman: float
    zeta: float
    turned: float
    divergence: float
    traces: float

    @classmethod
    def of(cls, problem: ConstrainedLangevin, h: float) -> "ExpansionWeights":
        """Return the coefficients of a step of size h, for any eps from 0 to infinity."""
        over, variance = PenaltyIntegrals.over(h, problem.eps), problem.strength**2
        lag, half = over.first - h, 0.5 * over.omega**2
        return cls(
            fixman=0.25 * variance * over.second,
            quadratic=half,
            noise=problem.strength * float(np.sqrt(over.second / h) - 1.0),
            drift=lag,
            normal_fixman=0.125 * variance * over.omega * over.first,
            zeta=over.omega,
            turned=half,
            divergence=0.5 * variance * lag,
            traces=0.5 * variance * (h - over.second),
        )


class UniformExpansion(LangevinScheme):
    """x+ = x + sqrt(h) A + h B: (2.2) up to h^(3/2) in the weak sense, uniformly in eps.

    On a path the two differ by terms of size h and mean 0; for eps -> 0 the expansion leaves the manifold.

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
        replace(STABLE, when=PENALISED),
        Claim(
            measure="strong",
            value=1.0,
            when=PENALISED,
            source="for fixed eps: Euler-Maruyama up to terms of size h^(3/2) and mean 0, or h^2; additive noise",
        ),
        Claim(
            measure="uniformity",
            value=0.5,
            source="Laurent 2022, section 2: it would also yield a uniformly accurate scheme; along paths measured",
        ),
        Claim(
            measure="uniformity",
            quantities=("one step",),
            value=1.5,
            source="Laurent 2022, Proposition 3.3: the local weak error, for all eps",
        ),
    )
    source: ClassVar[str] = "Laurent 2022, Proposition 3.3"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        return ExpansionWeights.of(problem, h)

    def step(self, problem: ConstrainedLangevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        at, f, given = problem.near(state), problem.drift(state), self.weights(problem, h)
        free = problem.strength * noise.dW + h * f + given.fixman * at.fixman + given.quadratic * at.quadratic
        return Step(state + free + at.J.transposed(at.gram.solve(_normal(at, f, noise.dW, given))))


def _normal(at: ConstraintGeometry, f: Array, dW: Array, given: ExpansionWeights) -> Array:
    """Return r in the part g G^{-1} r of a step that acts along the normals, shape (q, P)."""
    turned = np.einsum("kdp,dp->kp", at.problem.turn_normals(at.x, at.relaxation), at.relaxation)
    moved = given.noise * dW + given.drift * f + given.normal_fixman * at.fixman - given.quadratic * at.quadratic
    traces = given.divergence * at.divergence + given.traces * at.normal_traces
    return np.asarray(at.J.times(moved) - given.zeta * at.zeta - given.turned * turned + traces)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [UniformExpansion()]
