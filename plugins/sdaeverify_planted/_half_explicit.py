"""Parts of the half-explicit step."""

from sdaeverify import Array, ConstraintJacobian, HolonomicSDAE, HolonomicState


def kick(problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, dw: Array) -> Array:
    """Return M^{-1} (h a + B dw)."""
    r, v, _ = state
    return problem.inverse_mass(h * problem.force(t, r, v) + problem.diffused(t, r, v, dw))


def multiplier(problem: HolonomicSDAE, r: Array, old: ConstraintJacobian, x: Array) -> Array:
    """Return lambda with Dg(r) (x + M^{-1} grad g(r_0) lambda) = 0, for the linearisation at another position r_0."""
    J = problem.linearised(r)
    return -J.gram(old).solve(J.times(x))
