"""The implicit Euler scheme for constrained mechanics in the form of Gear, Gupta and Leimkuhler."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, HolonomicSDAE, HolonomicState, Increment, ParameterError, Scheme, Step, hookimpl

from ._continuation import continue_in_stages
from ._equations import Equations, Unknowns
from ._newton import Stop, solve_equations

TO_ROUNDING = Claim(measure="drift", value="round-off", source="Lindner et al. 2018, section 4.1, scheme (A)")


@dataclass(frozen=True)
class ImplicitEulerGGL(Scheme):
    """Drift and multipliers at the new state, noise at the old one; both constraints are equations of the step.

        r = r_0 + h ( v + M^{-1} grad g(r) nu )
        v = v_0 + M^{-1} { h [ a(t + h, r, v) + grad g(r) lambda ] + B(t, r_0, v_0) dw }
        g(r) = 0,   Dg(r) v = 0,   mu+ = mu + h lambda

    nu vanishes with h; lambda is of size h^{-1/2} and has no limit, only its sum mu converges. The root is the one
    that Newton's method reaches with Armijo's line search. If the method fails on a path, continuation in the noise
    is tried; if that fails as well, the path keeps its state and is counted.

    Attributes
    ----------
    guess : str
        Initial guess of Newton's method, always with nu = 0. ``V0``: (r_0, v_0) with lambda = 0; ``V2``: (r_0, v_0)
        with the multiplier of the explicit scheme; ``V1``: also its position and velocity before any projection.
    tolerance : float
        The iteration ends if no component of the equations exceeds the tolerance or its rounding error; with 0 it
        continues to rounding errors.
    max_iterations : int
        Largest number of iterations of each call of Newton's method.
    stages : int
        Number of stages of the continuation in the noise; 1 for no continuation.
    """

    guess: str = "V2"
    tolerance: float = 0.0
    max_iterations: int = 50
    stages: int = 4

    name: ClassVar[str] = "implicit-euler-ggl"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="measured"),
        Claim(measure="strong", value=1.0, when=frozenset({"vanishing-milstein-term"}), source="measured"),
        Claim(measure="weak", value=1.0, source="measured"),
        Claim(measure="invariant", value=1.0, source="measured"),
    )
    source: ClassVar[str] = "Lindner et al. 2018, section 4.1, scheme (A)"

    def __post_init__(self) -> None:
        if self.guess not in {"V0", "V1", "V2"}:
            raise ParameterError(f"guess must be V0, V1 or V2, got {self.guess!r}")
        if not 0.0 <= self.tolerance < 1.0:
            raise ParameterError(f"tolerance must be at least 0 and below 1, got {self.tolerance!r}")
        for name in ("max_iterations", "stages"):
            if not getattr(self, name) >= 1:
                raise ParameterError(f"{name} must be at least 1, got {getattr(self, name)!r}")

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Orders, and constraints kept to rounding unless a tolerance stops Newton's method earlier."""
        return self.claims if self.tolerance else (*self.claims, TO_ROUNDING)

    def refuses(self, problem: HolonomicSDAE) -> str:
        """Refuse forces without derivatives."""
        return problem.why_not_derivative_of_force()

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        equations = Equations(problem, t + h, h, r, v, self._kick(problem, state, t, h, noise))
        stop = Stop(self.tolerance, self.max_iterations)
        root = solve_equations(equations, self._guess(equations, t), stop)
        if self.stages > 1 and not root.found.all():
            root = continue_in_stages(equations, root, stop, self.stages)
        xi, new_v, lam, nu = root.x
        new = (np.where(root.found, part, old) for part, old in ((r + xi, r), (new_v, v), (mu + lam, mu)))
        costs = {"newton_iterations": root.iterations, "line_search_halvings": root.halvings}
        return Step(HolonomicState(*new), ~root.found, outputs={"lambda": lam, "nu": nu / h}, costs=costs)

    def _kick(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Array:
        return problem.diffused(t, state.r, state.v, noise.dW)

    def _guess(self, equations: Equations, t: float) -> Unknowns:
        problem, h, r, v, kick = equations.problem, equations.h, equations.r, equations.v, equations.kick
        J = problem.linearised(r)
        nothing = np.zeros_like(J.times(v))
        if self.guess == "V0":
            return Unknowns(np.zeros_like(r), v, nothing, nothing)
        impulse: Array = h * problem.force(t, r, v) + kick
        lam = h * problem.inherent_multiplier(J, r, v, impulse / h)
        if self.guess == "V2":
            return Unknowns(np.zeros_like(r), v, lam, nothing)
        return Unknowns(h * v, v + problem.inverse_mass(impulse + J.transposed(lam)), lam, nothing)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme with the guess that is robust on coarse and on fine steps."""
    return [ImplicitEulerGGL()]
