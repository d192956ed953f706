"""Uniformly accurate and other schemes for stiff penalties with one wrong part."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, ConstrainedLangevin, ConstraintGeometry, Gram, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.penalised._multiplier import OldNormals
from sdaeverify_schemes.penalised._uniform_weights import Weights
from sdaeverify_schemes.penalised.uniform_expansion import ExpansionWeights, UniformExpansion
from sdaeverify_schemes.penalised.uniformly_accurate import UniformlyAccurate

# The uniformly accurate integrator with a term omitted, doubled or evaluated elsewhere.
#
# On the torus a missing Fixman term lowers the error, on spheres and matrix groups the multiplier absorbs it, and on
# the exponential strip it has a tangential component. Changes of E zeta^2 are detectable on the torus as well.


@dataclass(frozen=True)
class ScaledTerms(UniformlyAccurate):
    """Coefficients of the step multiplied by given factors; 1 is right.

    Attributes
    ----------
    fixman, quadratic, turning, divergence : float
        Factors of grad ln det G and g'(w) c in the predictor, and of g^T grad ln det G and div g in the level.
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
    """sqrt(eps/2) (1 - e^{-2h/eps}) instead of sqrt((eps/2) (1 - e^{-2h/eps})): right for eps far below h."""

    name: ClassVar[str] = "planted-uniform-half-root"

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        gone = -np.expm1(-2.0 * h / problem.eps) if problem.eps else 1.0
        return right._replace(noise=float(right.noise * np.sqrt(gone)))


class OtherNoise(UniformlyAccurate):
    """The level has the noise of the step with opposite sign, another xi of the same law."""

    name: ClassVar[str] = "planted-uniform-other-noise"

    def level(self, at: ConstraintGeometry, f: Array, dW: Array, weights: Weights) -> Array:
        """Return zeta(x+), shape (q, P)."""
        return super().level(at, f, -dW, weights)


class GramOfTheManifold(UniformlyAccurate):
    """G at x - w, a point on the manifold to first order, instead of G at x."""

    name: ClassVar[str] = "planted-uniform-gram-of-the-manifold"

    def near(self, problem: ConstrainedLangevin, x: Array) -> ConstraintGeometry:
        """Return the geometry of the constraint at x, except its Gram matrix."""
        return _Elsewhere(problem, x)


class _Elsewhere(ConstraintGeometry):
    @cached_property
    def gram(self) -> Gram:
        return self.problem.near(self.x - self.problem.near(self.x).relaxation).gram


class OneGramMissing(UniformlyAccurate):
    """The quadratic term is g'(w) zeta, without one of its two factors G^{-1}; no effect if G is 1."""

    name: ClassVar[str] = "planted-uniform-one-gram-missing"

    def near(self, problem: ConstrainedLangevin, x: Array) -> ConstraintGeometry:
        """Return the geometry of the constraint at x, except its quadratic term."""
        return _Undivided(problem, x)


class _Undivided(ConstraintGeometry):
    @cached_property
    def quadratic(self) -> Array:
        return self.problem.contraction(self.x, self.relaxation[:, None] * self.zeta)


class Subtracted(UniformlyAccurate):
    """eps (1 - e^{-h/eps}) by subtraction, which cancels for eps much larger than h; no claim on invariant laws."""

    name: ClassVar[str] = "planted-uniform-subtraction"
    claims: ClassVar[tuple[Claim, ...]] = tuple(
        claim for claim in UniformlyAccurate.claims if claim.measure in {"weak", "strong"}
    )

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right, variance = super().weights(problem, h), problem.strength**2
        mean = problem.eps * float(1.0 - np.exp(-h / problem.eps)) if problem.eps else 0.0
        return right._replace(drift=mean, turning=0.25 * variance * mean, divergence=0.5 * variance * mean)


# The explicit expansion of the uniformly accurate step with a term omitted or with a wrong coefficient.
#
# At a fixed eps all of them have the right order, but not uniformly in eps in one step.


@dataclass(frozen=True)
class ScaledExpansion(UniformExpansion):
    """Coefficients of the step multiplied by given factors; 1 is right.

    Attributes
    ----------
    traces, quadratic : float
        Factors of tau, the traces over the normal space, and of g'(w) c - P g'(w) c.
    """

    traces: float = 1.0
    quadratic: float = 1.0

    name: ClassVar[str] = "planted-expansion-scaled-terms"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        return right._replace(traces=self.traces * right.traces, quadratic=self.quadratic * right.quadratic)


class NoProjector(UniformExpansion):
    """(sigma^2/8) eps omega^2 grad ln det G instead of its normal part."""

    name: ClassVar[str] = "planted-expansion-no-projector"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        return right._replace(fixman=right.fixman + right.normal_fixman, normal_fixman=0.0)


class RootForSquare(UniformExpansion):
    """The coefficient s of the noise instead of its square: 1 - s for 1 - s^2."""

    name: ClassVar[str] = "planted-expansion-root-for-square"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        full = 0.5 * problem.strength**2 * h
        if not full:
            return right
        return right._replace(traces=full * float(1.0 - np.sqrt(max(0.0, 1.0 - right.traces / full))))


# The uniformly accurate integrator that converges to its limit eps = 0 too slowly, or to a wrong limit, or leaves M.
#
# For a fixed eps all of them converge as the right scheme.


ASYMPTOTIC = Claim(measure="limits", quantities=("x", "zeta"), value=0.5, source="Laurent 2022, Theorem 2.9")


class RootTwice(UniformlyAccurate):
    """sigma (I_2/h)^{1/4} instead of sigma (I_2/h)^{1/2}, so that zeta is of size eps^{1/4}."""

    name: ClassVar[str] = "planted-limit-root-twice"

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        return right._replace(noise=(problem.strength * right.noise) ** 0.5)


class ForgottenLimit(UniformlyAccurate):
    """h/eps is set to 0 if eps is 0: the level set of the previous step, plus the noise."""

    name: ClassVar[str] = "planted-limit-forgotten"

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        return right if problem.eps else right._replace(zeta=1.0, noise=problem.strength)


class Leaving(UniformExpansion):
    """The explicit expansion, which leaves the manifold in the limit, with the claim of staying on it."""

    name: ClassVar[str] = "planted-limit-leaving"
    claims: ClassVar[tuple[Claim, ...]] = (ASYMPTOTIC,)


# The uniformly accurate integrator with multipliers that cost too much, or increasingly much for small eps.


@dataclass(frozen=True)
class Led(UniformlyAccurate):
    """The level is approached in stages: one for each halving of eps below a step, or a fixed number.

    Attributes
    ----------
    stages : int
        Fixed number of stages; 0 for a number that depends on eps.
    """

    stages: int = 0

    name: ClassVar[str] = "planted-uniform-led"

    def onto(self, at: ConstraintGeometry, y: Array, level: Array) -> Step:
        """Return the step from the point of `at` to y + g lambda on the level set.

        Parameters
        ----------
        at : ConstraintGeometry
            Geometry at the old point.
        y : ndarray, shape (d, P)
            Result of the step without constraint.
        level : ndarray, shape (q, P)
            Value zeta of the level set.
        """
        halvings = int(np.ceil(np.log2(1.0 / at.problem.eps))) if at.problem.eps else 1
        new = OldNormals(at, y, level).follow(self.stages or max(1, halvings))
        return Step(
            np.where(new.found, new.x, at.x),
            ~new.found,
            costs={"newton_iterations": new.matrices, "updates": new.updates},
        )


BUGS = [
    Planted("strip: no Fixman term in the predictor", ScaledTerms(fixman=0.0), "exponential-strip"),
    Planted("strip: Fixman term with twice its weight", ScaledTerms(fixman=2.0), "exponential-strip"),
    Planted("strip: no quadratic term", ScaledTerms(quadratic=0.0), "exponential-strip"),
    Planted("strip: quadratic term with the wrong sign", ScaledTerms(quadratic=-1.0), "exponential-strip"),
    Planted("strip: no Fixman term in the level", ScaledTerms(turning=0.0), "exponential-strip"),
    Planted("strip: no div g in the level", ScaledTerms(divergence=0.0), "exponential-strip"),
    Planted("strip: square root of half of its argument", HalfRoot(), "exponential-strip"),
    Planted("strip: other noise in the level", OtherNoise(), "exponential-strip"),
    Planted("strip: Gram matrix of the manifold", GramOfTheManifold(), "exponential-strip"),
    Planted("strip: quadratic term with one Gram matrix missing", OneGramMissing(), "exponential-strip"),
    Planted("torus: no div g in the level", ScaledTerms(divergence=0.0), "torus"),
    Planted("torus: square root of half of its argument", HalfRoot(), "torus"),
    Planted("torus: quadratic term with one Gram matrix missing", OneGramMissing(), "torus"),
    Planted("strip: 1 - e by subtraction", Subtracted(), "exponential-strip[eps=1e18]"),
    Planted("the traces over the normal space are missing", ScaledExpansion(traces=0.0), "tube-torus"),
    Planted("the quadratic term is missing", ScaledExpansion(quadratic=0.0), "exponential-strip"),
    Planted("a projector is missing", NoProjector(), "exponential-strip"),
    Planted("s in place of its square", RootForSquare(), "tube-torus"),
    Planted("a root taken twice", RootTwice(), "affine-constraint"),
    Planted("another scheme where eps is 0", ForgottenLimit(), "affine-constraint"),
    Planted("the manifold is left in the limit", Leaving(), "penalised-sphere"),
    Planted("iterations that grow as eps tends to 0", Led(), "affine-constraint"),
    Planted("three times as many iterations", Led(stages=24), "affine-constraint"),
]


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return BUGS
