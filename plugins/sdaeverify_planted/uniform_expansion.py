"""The explicit expansion of the uniformly accurate step with a term left out or with another coefficient.

At a fixed eps all of them have the order of the right one. One step has not, uniformly in eps.
"""

from typing import ClassVar

import numpy as np

from sdaeverify import ConstrainedLangevin, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.penalised.uniform_expansion import ExpansionWeights, UniformExpansion


class NoTraces(UniformExpansion):
    """Without tau, the traces over the normal space."""

    name: ClassVar[str] = "planted-expansion-no-traces"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        return super().weights(problem, h)._replace(traces=0.0)


class NoQuadratic(UniformExpansion):
    """Without g'(w) c - P g'(w) c."""

    name: ClassVar[str] = "planted-expansion-no-quadratic"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        return super().weights(problem, h)._replace(quadratic=0.0)


class NoProjector(UniformExpansion):
    """(sigma^2/8) eps omega^2 grad ln det G in place of its normal part."""

    name: ClassVar[str] = "planted-expansion-no-projector"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        return right._replace(fixman=right.fixman + right.normal_fixman, normal_fixman=0.0)


class RootForSquare(UniformExpansion):
    """The coefficient s of the noise where its square belongs: 1 - s for 1 - s^2."""

    name: ClassVar[str] = "planted-expansion-root-for-square"

    def weights(self, problem: ConstrainedLangevin, h: float) -> ExpansionWeights:
        """Return the coefficients of a step of size h."""
        right = super().weights(problem, h)
        full = 0.5 * problem.strength**2 * h
        return right._replace(traces=full * float(1.0 - np.sqrt(max(0.0, 1.0 - right.traces / full))))


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    return [
        Planted(bug="the traces over the normal space are missing", scheme=NoTraces(), problem="tube-torus"),
        Planted(bug="the quadratic term is missing", scheme=NoQuadratic(), problem="exponential-strip"),
        Planted(bug="a projector is missing", scheme=NoProjector(), problem="exponential-strip"),
        Planted(bug="s in place of its square", scheme=RootForSquare(), problem="tube-torus"),
    ]
