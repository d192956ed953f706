"""The Euler scheme with projection for constrained Langevin dynamics."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, ConstrainedLangevin, Increment, ParameterError, Scheme, Step, hookimpl

from ._implicit_langevin import ImplicitLangevin

KEPT = frozenset({"constrained"})
MISSING = "measured; its local error is the Milstein term of sigma Pi o dW, of size h"


@dataclass(frozen=True)
class ConstrainedEuler(ImplicitLangevin):
    """x+ = x + sqrt(h) sigma xi + h f(x) + g lambda, zeta(x+) = 0.

    The scheme ignores eps: for eps > 0 it runs as a competitor whose error does not vanish with h, without claims.

    Attributes
    ----------
    direction : str
        Normals: ``old`` for g(x), (1.6); ``new`` for g(x+), (2.7).
    """

    direction: str = "old"

    name: ClassVar[str] = "constrained-euler"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=1.0, when=KEPT, source="Laurent 2022, (1.6) and (2.7)"),
        Claim(measure="invariant", value=1.0, when=KEPT, source="Laurent 2022, section 1: the weak order at least"),
        Claim(measure="strong", value=0.5, when=KEPT, source=MISSING),
        Claim(measure="drift", value="round-off", when=KEPT, source="zeta(x+) = 0 is solved"),
    )
    source: ClassVar[str] = "Laurent 2022, (1.6) and (2.7)"

    def __post_init__(self) -> None:
        if self.direction not in {"old", "new"}:
            raise ParameterError(f"direction must be old or new, got {self.direction!r}")
        super().__post_init__()

    @property
    def implicitness(self) -> float:
        """Parameter theta of the point at which normals are taken."""
        return 1.0 if self.direction == "new" else 0.0

    def step(self, problem: ConstrainedLangevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        at, y = problem.near(state), state + problem.strength * noise.dW + h * problem.drift(state)
        return self.onto(at, y, np.zeros((problem.constraints, y.shape[1])))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme with both directions."""
    return [ConstrainedEuler(), ConstrainedEuler(direction="new")]
