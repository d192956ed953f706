"""The uniformly accurate integrator of Laurent (2022): one error bound for all stiffness parameters eps."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import (
    Array,
    Claim,
    ConstrainedLangevin,
    ConstraintGeometry,
    Increment,
    ParameterError,
    Scheme,
    Step,
    hookimpl,
)

from .._small_steps import STABLE
from ._implicit_langevin import ImplicitLangevin
from ._uniform_weights import Weights

STILL = ("x without noise", "zeta without noise")
CONTRACTION = "measured, O(4) needs most; Laurent 2022, Theorem 2.12: a contraction uniformly in eps"
MEAN = "measured; of (sigma^2/2) xi^T H xi, the level has the mean only"


@dataclass(frozen=True)
class UniformlyAccurate(ImplicitLangevin):
    """A predictor, and a multiplier that moves it to the value of zeta prescribed by the penalty.

    With c = G^{-1} zeta, w = g c, I_1 = eps omega, I_2 = (eps/2) (1 - e^2), e = exp(-h/eps), omega = 1 - e,

        x+ = x + sqrt(h) sigma xi + h f + ((1 - 2 theta)/2) omega^2 g'(w) c
               + (sigma^2/4) [(1 - 2 theta) I_2 + 2 theta sqrt(h I_2)] grad ln det G + g(x + theta (x+ - x)) lambda,
        zeta(x+) = e zeta + sigma sqrt(I_2) g^T xi + I_1 (g^T f + (sigma^2/4) g^T grad ln det G + (sigma^2/2) div g).

    For theta = 0 and q = 1 this is (2.4). A further line of the printed level vanishes identically for any q.
    At eps = 0 it is constrained Euler: (1.6) for theta = 0, (2.7) for theta = 1.

    Attributes
    ----------
    theta : float
        Position of the normals, from 0, (2.2), to 1, Remark 2.11.
    """

    theta: float = 0.0

    name: ClassVar[str] = "uniformly-accurate"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, source="Laurent 2022, Remark 2.8: for fixed eps and for eps = 0"),
        Claim(measure="invariant", value=1.0, source="Laurent 2022, section 1: the weak order at least"),
        Claim(measure="strong", value=0.5, source=MEAN),
        Claim(
            measure="drift",
            value="round-off",
            when=frozenset({"constrained"}),
            source="zeta(x+) = 0 is solved where eps = 0",
        ),
        Claim(measure="uniformity", value=0.5, source="Laurent 2022, Theorem 2.7"),
        Claim(
            measure="uniformity",
            quantities=("one step",),
            value=1.5,
            source="Laurent 2022, Propositions 3.3 and 3.7: the local weak error, for all eps",
        ),
        Claim(measure="limits", value=0.5, source="Laurent 2022, Theorem 2.9"),
        Claim(measure="limits", quantities=STILL, value=1.0, source="Laurent 2022, Theorem 2.9, for sigma = 0"),
        Claim(measure="effort", value="iterations", bound=16, share=0.9, source=CONTRACTION),
        STABLE,
    )
    source: ClassVar[str] = "Laurent 2022, (2.2), (2.4) and Remark 2.11"

    def __post_init__(self) -> None:
        if not 0.0 <= self.theta <= 1.0:
            raise ParameterError(f"theta must be between 0 and 1, got {self.theta!r}")
        super().__post_init__()

    @property
    def implicitness(self) -> float:
        """Parameter theta of the point at which normals are taken."""
        return self.theta

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        return Weights.of(problem, h, self.theta)

    def near(self, problem: ConstrainedLangevin, x: Array) -> ConstraintGeometry:
        """Return the geometry of the constraint at x."""
        return problem.near(x)

    def level(self, at: ConstraintGeometry, f: Array, dW: Array, weights: Weights) -> Array:
        """Return zeta(x+), shape (q, P).

        Parameters
        ----------
        at : ConstraintGeometry
            Geometry at the old point.
        f : ndarray, shape (d, P)
            Drift at the old point.
        dW : ndarray, shape (d, P)
            Increment of the noise.
        weights : Weights
            Coefficients of the terms, which depend on h and eps.
        """
        moved = weights.noise * dW
        if not weights.drift:
            return weights.zeta * at.zeta + at.J.times(moved)
        moved = moved + weights.drift * f + weights.turning * at.fixman
        return weights.zeta * at.zeta + at.J.times(moved) + weights.divergence * at.divergence

    def prepare(self, problem: ConstrainedLangevin, h: float) -> Callable[[Array, float, Increment], Step]:
        """Return the step with its coefficients computed once."""
        weights = self.weights(problem, h)

        def stepper(state: Array, t: float, noise: Increment) -> Step:
            at, f = self.near(problem, state), problem.drift(state)
            y = state + problem.strength * noise.dW + h * f
            if weights.fixman:
                y = y + weights.fixman * at.fixman
            if weights.quadratic:
                y = y + weights.quadratic * at.quadratic
            return self.onto(at, y, self.level(at, f, noise.dW, weights))

        return stepper

    def step(self, problem: ConstrainedLangevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        return self.prepare(problem, h)(state, t, noise)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register (2.2), with normal and with three-point variables, and Remark 2.11."""
    return [UniformlyAccurate(), UniformlyAccurate(xi="three-point"), UniformlyAccurate(theta=1.0)]
