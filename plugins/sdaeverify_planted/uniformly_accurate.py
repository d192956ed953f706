"""The uniformly accurate integrator with a term left out, doubled or taken elsewhere.

On the torus a missing Fixman term lowers the error, on spheres and matrix groups the multiplier absorbs it, and on
the exponential strip it has a tangential component. What changes E zeta^2 is seen on the torus, too.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, ConstrainedLangevin, ConstraintGeometry, Gram, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.penalised._uniform_weights import Weights
from sdaeverify_schemes.penalised.uniformly_accurate import UniformlyAccurate

STRIP = "exponential-strip"


@dataclass(frozen=True)
class ScaledTerms(UniformlyAccurate):
    """Coefficients of the step times given factors; 1 is right.

    Attributes
    ----------
    fixman, quadratic, turning, divergence : float
        Of grad ln det G and g'(w) c in the predictor, of g^T grad ln det G and div g in the level.
    """

    fixman: float = 1.0
    quadratic: float = 1.0
    turning: float = 1.0
    divergence: float = 1.0

    name: ClassVar[str] = "planted-uniform-scaled-terms"

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        names = ("fixman", "quadratic", "turning", "divergence")
        return right._replace(**{name: getattr(self, name) * getattr(right, name) for name in names})


class HalfRoot(UniformlyAccurate):
    """sqrt(eps/2) (1 - e^{-2h/eps}) in place of sqrt((eps/2) (1 - e^{-2h/eps})): right for eps far below h."""

    name: ClassVar[str] = "planted-uniform-half-root"

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        gone = -np.expm1(-2.0 * h / problem.eps) if problem.eps else 1.0
        return right._replace(noise=float(right.noise * np.sqrt(gone)))


class OtherNoise(UniformlyAccurate):
    """The level has the noise of the step with opposite sign: another xi of the same law."""

    name: ClassVar[str] = "planted-uniform-other-noise"

    def level(self, at: ConstraintGeometry, f: Array, dW: Array, weights: Weights) -> Array:
        """Return zeta(x+), shape (q, P)."""
        return super().level(at, f, -dW, weights)


class GramOfTheManifold(UniformlyAccurate):
    """G at x - w, which is on the manifold to first order, in place of G at x."""

    name: ClassVar[str] = "planted-uniform-gram-of-the-manifold"

    def near(self, problem: ConstrainedLangevin, x: Array) -> ConstraintGeometry:
        """Return the geometry of the constraint at x, but for its Gram matrix."""
        return _Elsewhere(problem, x)


@dataclass(frozen=True, eq=False)
class _Elsewhere(ConstraintGeometry):
    @cached_property
    def gram(self) -> Gram:
        return self.problem.near(self.x - self.problem.near(self.x).relaxation).gram


class OneGramMissing(UniformlyAccurate):
    """The quadratic term is g'(w) zeta: one of its two factors G^{-1} is missing; no matter where G is 1."""

    name: ClassVar[str] = "planted-uniform-one-gram-missing"

    def near(self, problem: ConstrainedLangevin, x: Array) -> ConstraintGeometry:
        """Return the geometry of the constraint at x, but for its quadratic term."""
        return _Undivided(problem, x)


@dataclass(frozen=True, eq=False)
class _Undivided(ConstraintGeometry):
    @cached_property
    def quadratic(self) -> Array:
        return self.problem.contraction(self.x, self.relaxation[:, None] * self.zeta)


class Subtracted(UniformlyAccurate):
    """eps (1 - e^{-h/eps}) by subtraction: cancelled for eps much larger than h; no claim about the long run."""

    name: ClassVar[str] = "planted-uniform-subtraction"
    claims: ClassVar[tuple[Claim, ...]] = tuple(
        claim for claim in UniformlyAccurate.claims if claim.measure in {"weak", "strong"}
    )

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right, variance = super().weights(problem, h), problem.strength**2
        mean = problem.eps * float(1.0 - np.exp(-h / problem.eps)) if problem.eps else 0.0
        return right._replace(drift=mean, turning=0.25 * variance * mean, divergence=0.5 * variance * mean)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, UniformlyAccurate] = {
        "no Fixman term in the predictor": ScaledTerms(fixman=0.0),
        "Fixman term with twice its weight": ScaledTerms(fixman=2.0),
        "no quadratic term": ScaledTerms(quadratic=0.0),
        "quadratic term with the wrong sign": ScaledTerms(quadratic=-1.0),
        "no Fixman term in the level": ScaledTerms(turning=0.0),
        "no div g in the level": ScaledTerms(divergence=0.0),
        "square root of half of its argument": HalfRoot(),
        "other noise in the level": OtherNoise(),
        "Gram matrix of the manifold": GramOfTheManifold(),
        "quadratic term with one Gram matrix missing": OneGramMissing(),
    }
    both = (
        "no div g in the level",
        "square root of half of its argument",
        "quadratic term with one Gram matrix missing",
    )
    planted = [Planted(bug=f"strip: {bug}", scheme=scheme, problem=STRIP) for bug, scheme in bugs.items()]
    planted += [Planted(bug=f"torus: {bug}", scheme=bugs[bug], problem="torus") for bug in both]
    return [*planted, Planted(bug="strip: 1 - e by subtraction", scheme=Subtracted(), problem=f"{STRIP}[eps=1e18]")]
