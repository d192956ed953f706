"""The semi-implicit projection-based Euler scheme of Lindner et al. (2018), section 4.1."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, HolonomicSDAE, HolonomicState, Increment, ParameterError, Scheme, Step, hookimpl

from ._position_projection import Projection, check_projection
from ._projection_orders import EXACT, ORDERS


@dataclass(frozen=True)
class SemiImplicitProjectionEuler(Scheme):
    """The position first, then the velocity with the drift at the new position.

    With the projector P_M and the Brownian increment dw,

        r+ = r + h v + M^{-1} grad g(r+) eta,                                         g(r+) = 0,
        v+ = v + M^{-1} [ h a(t + h, r+, v) + P_M B(t, r, v) dw + grad g(r+) l ],     Dg(r+) v+ = 0,
        mu+ = mu + l^ + l,                        P_M B dw = B dw + grad g l^.

    The term D^2 g(v, v) of the inherent SDE is part of l. The force is evaluated at the new time and the new
    position, as if time were a coordinate of the position. A path without root keeps its state and is counted.

    Attributes
    ----------
    noise_projector : str
        Point of P_M: ``old`` for P_M(r), as in Ito's integral, ``new`` for P_M(r+), which is implied by the
        projection of v+ and saves a linear system.
    solver : str
        Projection of positions: ``gram``, with the Gram matrix alone, or ``newton``, as in the source.
    tolerance : float
        Tolerance of this projection relative to the position; 0 for rounding.
    """

    noise_projector: str = "old"
    solver: str = "gram"
    tolerance: float = 0.0

    name: ClassVar[str] = "semi-implicit-projection-euler"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = (
        *ORDERS,
        Claim(measure="invariant", value=1.0, source="measured"),
        EXACT,
    )
    source: ClassVar[str] = "Lindner et al. 2018, section 4.1, (B')"

    def __post_init__(self) -> None:
        if self.noise_projector not in {"old", "new"}:
            raise ParameterError(f"noise_projector must be old or new, got {self.noise_projector!r}")
        check_projection(self.solver, self.tolerance)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims, without exact constraints if a projection has a tolerance."""
        return tuple(claim for claim in self.claims if not self.tolerance or claim != EXACT)

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        projection = Projection(self.solver, self.tolerance)
        new = projection(problem, r + h * v)
        kick, first = self._noise(problem, state, t, noise.dW)
        moved = v + problem.inverse_mass(h * problem.force(t + h, new.r, v)) + kick
        v_new, second = problem.tangent(new.J, moved)
        reached = HolonomicState(new.r, v_new, mu + first + second)
        failed = ~new.found
        if failed.any():
            reached = HolonomicState(*(np.where(failed, a, b) for a, b in zip(state, reached, strict=True)))
        return Step(reached, failed, outputs={"eta": new.eta}, costs={projection.counter: new.iterations})

    def _noise(
        self, problem: HolonomicSDAE, state: HolonomicState, t: float, dw: Array
    ) -> tuple[Array, Array | float]:
        """Return M^{-1} P_M B dw and l^, or M^{-1} B dw and 0."""
        kick = problem.inverse_mass(problem.diffused(t, state.r, state.v, dw))
        return (kick, 0.0) if self.noise_projector == "new" else problem.tangent(problem.linearised(state.r), kick)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme with both projectors."""
    return [SemiImplicitProjectionEuler(), SemiImplicitProjectionEuler(noise_projector="new")]
