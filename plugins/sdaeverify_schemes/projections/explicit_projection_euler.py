"""The explicit projection-based Euler scheme of Lindner et al. (2018), section 4.1, and its variant with skipping."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Claim, HolonomicSDAE, HolonomicState, Increment, ParameterError, Parts, Scheme, Step, hookimpl

from .._senses import in_probability
from ._position_projection import Projection, check_projection
from ._projection_orders import EXACT, ORDERS
from ._skipping import SkippingState, inherent_euler, projections

SKIPPED = Claim(
    measure="drift",
    value=1.0,
    source="measured, without any projection; with a fixed number of skipped steps 2 for g and 3/2 for Dg v",
)


@dataclass(frozen=True)
class ExplicitProjectionEuler(Scheme):
    """An Euler step for the inherent SDE, then projection of position and velocity along the new normals.

    With the projector P_M, the Gram matrix G_M and the Brownian increment dw,

        r^ = r + h v,
        v^ = v + M^{-1} { P_M(r) [h a + B dw] - h grad g G_M^{-1} D^2 g(v, v) } = v + M^{-1} [h a + B dw + grad g l^],
        r+ = r^ + M^{-1} grad g(r+) eta,                    g(r+) = 0,
        v+ = v^ + M^{-1} grad g(r+) l,                      Dg(r+) v+ = 0,
        mu+ = mu + l^ + l.

    Between two projections `skip` steps end at (r^, v^, mu + l^). A path without root keeps its state and is counted.

    No invariant law is claimed. On the unit circle, without force and noise, omega+ = omega sqrt(1 + (h omega)^2), so
    that a chain that reaches velocities of size sqrt(2 friction/h) explodes. Moments grow without bound as h tends to
    0. Therefore orders are claimed in probability.

    Attributes
    ----------
    skip : int
        Number n in (B_n) of steps without projection before each projected step.
    solver : str
        Projection of positions: ``gram``, with the Gram matrix alone, or ``newton``, as in the source.
    tolerance : float
        Tolerance of this projection relative to the position; 0 for rounding.
    """

    skip: int = 0
    solver: str = "gram"
    tolerance: float = 0.0

    name: ClassVar[str] = "explicit-projection-euler"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = in_probability(*ORDERS)
    source: ClassVar[str] = "Lindner et al. 2018, section 4.1, (B) and (B_n)"

    def __post_init__(self) -> None:
        if self.skip < 0:
            raise ParameterError(f"skip must be at least 0, got {self.skip!r}")
        check_projection(self.solver, self.tolerance)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Orders, and exact constraints if no projection is skipped or has a tolerance."""
        if self.skip:
            return (*self.claims, SKIPPED)
        return self.claims if self.tolerance else (*self.claims, EXACT)

    def enter(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float) -> SkippingState:
        """Return a state that counts as projected."""
        return SkippingState(*state, np.zeros((1, state.r.shape[-1])))

    def parts(self, problem: HolonomicSDAE, state: SkippingState) -> Parts:
        """Return position, velocity and multiplier."""
        return problem.parts(HolonomicState(*state[:3]))

    def step(self, problem: HolonomicSDAE, state: SkippingState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        free = inherent_euler(problem, state, t, h, noise.dW)
        due, projection = state.skipped[0] >= self.skip, Projection(self.solver, self.tolerance)
        if due.any():
            return projections(problem, state, free, due, projection)
        none = {projection.counter: np.full(len(due), np.nan)}
        return Step(free, np.zeros_like(due), outputs={"eta": np.zeros_like(state.mu)}, costs=none)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme with every projection and with every fourth."""
    return [ExplicitProjectionEuler(), ExplicitProjectionEuler(skip=3)]
