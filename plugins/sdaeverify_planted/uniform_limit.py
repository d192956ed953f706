"""The uniformly accurate integrator that tends to its limit eps = 0 too slowly, or to another one, or leaves M.

For a fixed eps all of them converge as the right one does.
"""

from typing import ClassVar

from sdaeverify import Claim, ConstrainedLangevin, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.penalised._uniform_weights import Weights
from sdaeverify_schemes.penalised.uniform_expansion import UniformExpansion
from sdaeverify_schemes.penalised.uniformly_accurate import UniformlyAccurate

ASYMPTOTIC = Claim(measure="limits", quantities=("x", "zeta"), value=0.5, source="Laurent 2022, Theorem 2.9")


class RootTwice(UniformlyAccurate):
    """sigma (I_2/h)^{1/4} for sigma (I_2/h)^{1/2}: zeta is of size eps^{1/4}."""

    name: ClassVar[str] = "planted-limit-root-twice"

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        return right._replace(noise=(problem.strength * right.noise) ** 0.5)


class ForgottenLimit(UniformlyAccurate):
    """h/eps is taken for 0 where eps is 0: the level set of the step before, with the noise on top."""

    name: ClassVar[str] = "planted-limit-forgotten"

    def weights(self, problem: ConstrainedLangevin, h: float) -> Weights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        return right if problem.eps else right._replace(zeta=1.0, noise=problem.strength)


class Leaving(UniformExpansion):
    """The explicit expansion, which leaves the manifold in the limit, with the claim that it does not."""

    name: ClassVar[str] = "planted-limit-leaving"
    claims: ClassVar[tuple[Claim, ...]] = (ASYMPTOTIC,)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="a root taken twice", scheme=RootTwice(), problem="affine-constraint"),
        Planted(bug="another scheme where eps is 0", scheme=ForgottenLimit(), problem="affine-constraint"),
        Planted(bug="the manifold is left in the limit", scheme=Leaving(), problem="penalised-sphere"),
    ]
