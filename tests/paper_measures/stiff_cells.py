"""What tests of measures of stiff families share: schemes with claims, right and wrong ones; how they are judged."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from facade import ConstrainedEuler, PenalisedEuler, UniformExpansion, UniformlyAccurate, affine_constraint
from sdaeverify import Claim, Settings
from sdaeverify.measuring import Evidence, Finding, Judgement, Measure, Tally

SETTINGS = Settings(paths=40, levels=3)
AFFINE = affine_constraint()
UNIFORM = Claim(measure="uniformity", value=0.5, source="test")
LIMITS = (
    Claim(measure="limits", quantities=("x", "zeta"), value=0.5, margin=0.02, source="test"),
    Claim(
        measure="limits", quantities=("x without noise", "zeta without noise"), value=1.0, margin=0.02, source="test"
    ),
)
EFFORT = Claim(measure="effort", value="iterations", bound=5, source="test")
CLAIMS = (UNIFORM, *LIMITS, EFFORT)


class Right(UniformlyAccurate):
    """The uniformly accurate integrator with all claims."""

    claims: ClassVar[tuple[Claim, ...]] = CLAIMS


class Explicit(PenalisedEuler):
    """The explicit scheme, which is unstable for h > eps, with all claims."""

    claims: ClassVar[tuple[Claim, ...]] = CLAIMS


class Ignorant(ConstrainedEuler):
    """The scheme of the limit, which ignores eps, with all claims."""

    claims: ClassVar[tuple[Claim, ...]] = CLAIMS


class Leaving(UniformExpansion):
    """The explicit expansion, which leaves the manifold in the limit, with all claims."""

    claims: ClassVar[tuple[Claim, ...]] = CLAIMS


@dataclass(frozen=True)
class Climbing(Right):
    """It reports iterations that grow by `slope` in each decade of 1/eps, or `more` of them on one path in 256."""

    slope: float = 0.0
    more: int = 0

    def prepare(self, problem, h):
        """Return the step."""
        step = super().prepare(problem, h)

        def stepper(state, t, noise):
            result = step(state, t, noise)
            taken = result.costs["newton_iterations"] + self.slope * np.log10(10.0 / problem.eps)
            taken = taken + self.more * (np.arange(len(taken)) % 256 == 7)
            return result._replace(costs={"newton_iterations": taken})

        return stepper


@dataclass(frozen=True)
class Rootless(UniformlyAccurate):
    """It has no root on some paths where eps is above a bound, for steps that are longer than another."""

    beyond: float = 0.0
    longer: float = 0.0

    def prepare(self, problem, h):
        """Return the step."""
        step = super().prepare(problem, h)
        fails = problem.eps > self.beyond and h > self.longer

        def stepper(state, t, noise):
            lost = (np.arange(state.shape[1]) % 10 == 0) & fails
            return step(state, t, noise)._replace(failed=lost)

        return stepper


def judged(measure: Measure, scheme, problem, *claims: Claim) -> dict[str, Finding]:
    """Probe and judge a cell, with other claims than the scheme's if some are given."""
    found = whole(measure, scheme, problem, *claims)
    assert {row.quantity for row in found.levels} == {finding.quantity for finding in found.findings}
    return {finding.quantity: finding for finding in found.findings}


def whole(measure: Measure, scheme, problem, *claims: Claim) -> Judgement:
    """Return all rows of a cell."""
    if claims:
        scheme = replace_claims(scheme, claims)
    assert measure.refuses(scheme, problem) == ""
    return measure.judge(Evidence(scheme, problem, problem, SETTINGS, probed(measure, scheme, problem), Tally()))


# Schemes that differ by their claims alone are equal: the probe knows nothing of claims.
@lru_cache
def probed(measure: Measure, scheme, problem) -> Tally:
    """Return the evidence on a cell."""
    return measure.probe(scheme, problem, SETTINGS)


def replace_claims(scheme, claims: tuple[Claim, ...]):
    """Return a scheme with other claims."""
    other = replace(scheme)
    object.__setattr__(other, "claims", claims)
    return other
