"""Noise of schemes for penalised and constrained Langevin dynamics, normal or bounded."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import (
    GAUSSIAN,
    THREE_POINT,
    Claim,
    ConstrainedLangevin,
    Law,
    ParameterError,
    Scheme,
)

LAWS = ("gaussian", "three-point", "clipped")


@dataclass(frozen=True)
class LangevinScheme(Scheme):
    """Base of schemes driven by sqrt(h) xi with independent xi of mean 0 and variance 1.

    For small h, bounded xi guarantee that a multiplier exists, Laurent (2022), section 2. Normal xi are nevertheless
    the default: their sums are Brownian, so that strong errors are defined, and the resulting steps without root are
    counted. The bound of clipped xi depends on the unit of time.

    Attributes
    ----------
    xi : str
        ``gaussian``; ``three-point``: 0 and +-sqrt(3) with P(xi = 0) = 2/3, (2.3); ``clipped``: normal, clipped at
        A_h = sqrt(2 p |ln h|).
    p : float
        Parameter of a clipped xi, whose mean square distance to a normal one is at most h^p.
    """

    xi: str = "gaussian"
    p: float = 4.0

    form: ClassVar[type[ConstrainedLangevin]] = ConstrainedLangevin

    def __post_init__(self) -> None:
        if self.xi not in LAWS:
            raise ParameterError(f"xi must be {', '.join(LAWS[:-1])} or {LAWS[-1]}, got {self.xi!r}")
        if not 0.0 < self.p < np.inf:
            raise ParameterError(f"p must be positive and finite, got {self.p!r}")

    @property
    def law(self) -> Law:
        """Law of dW."""
        return {"gaussian": GAUSSIAN, "three-point": THREE_POINT}.get(self.xi) or Law.clipped_gaussian(self.p)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims, without those of a strong order if sums of xi are not Brownian."""
        return tuple(claim for claim in self.claims if not (self.law.bounded and claim.measure == "strong"))
