"""Euler-Maruyama with projection onto the invariant manifold of an SDE."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl

from ._old_normals import onto_constraint

NORMAL = "on the manifold, the projection adds the Milstein term: D^2 g(B_j, B_k) = -Dg DB_j B_k"


class ProjectedEuler(Scheme):
    """An Euler-Maruyama step y = x + h f + B dW, then x+ = y + grad g(y) kappa with g(x+) = 0.

    Because f and B are those of Ito's equation, g(y) = (1/2) D^2 g(B dW, B dW) - (h/2) sum_j D^2 g(B_j, B_j) has mean
    0 up to O(h^2), and the projection moves y by a term of size h and mean 0, plus one of size h^(3/2) that is odd in
    dW: any transversal direction gives a consistent scheme. If DB_j B_k is normal, normals at x, at y or at x+ give
    the missing Milstein term, whereas a fixed direction does not. Normals at y need no second Jacobian.

    kappa is the root that Newton's method reaches from 0 with Dg(x+) grad g(y) positive definite; a path without such
    a root keeps its state and is counted.
    """

    name: ClassVar[str] = "projected-euler"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="Milstein's theorem: local errors h and h^2 in the mean"),
        Claim(measure="strong", value=1.0, when=frozenset({"normal-milstein-term"}), source=NORMAL),
        Claim(measure="weak", value=1.0, source="local errors: g(y) has mean 0 up to O(h^2)"),
        Claim(measure="invariant", value=1.0, source="measured"),
        Claim(measure="drift", value="round-off", source="g(x+) = 0 is solved"),
    )
    source: ClassVar[str] = "Hairer, Lubich & Wanner 2006, section IV.4, for Euler-Maruyama"

    def refuses(self, problem: SDE) -> str:
        """Refuse problems without constraint."""
        return "" if problem.has_constraints else "the problem has no constraint to project onto"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        y = x + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
        new = onto_constraint(problem, y, problem.linearised(y))
        failed = ~new.found
        costs = {"newton_iterations": new.iterations}
        return Step(np.where(failed, x, new.r), failed, outputs={"kappa": new.kappa}, costs=costs)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [ProjectedEuler()]
