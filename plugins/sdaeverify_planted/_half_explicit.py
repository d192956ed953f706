"""Parts of the half-explicit step."""

import numpy as np

from sdaeverify import Array, HolonomicSDAE, HolonomicState
from sdaeverify.numerics import apply, solve


def kick(problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, dw: Array) -> Array:
    """Return M^{-1} (h a + B dw)."""
    r, v, _ = state
    return problem.inverse_mass(h * problem.force(t, r, v) + apply(problem.diffusion(t, r, v), dw))


def multiplier(problem: HolonomicSDAE, r: Array, normals: Array, x: Array) -> Array:
    """Return lambda with Dg(r) (x + N^T lambda) = 0."""
    Dg = problem.dg(r)
    return -solve(np.einsum("mnp,knp->mkp", Dg, normals), apply(Dg, x))
