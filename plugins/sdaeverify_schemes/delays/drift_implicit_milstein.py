"""Milstein's scheme for equations of index 1, implicit in the drift and the constraint."""

from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, DelayState, Increment, IndexOneSDAE, Scheme, Step, hookimpl
from sdaeverify.numerics import directional, is_analytic, solve

from .._small_steps import STABLE
from ._root import hold_failed, regular
from ._theta import Begun, solve_coupled

PAPER = "Winkler 2004: drift-implicit schemes keep on an equation of index 1 the order that they have on an SDE"
LOCAL = "a step is off by h^(3/2) along paths and by h^2 in the mean: Milstein & Tretyakov 2004, Theorem 1.1"


class DriftImplicitMilstein(Scheme):
    """x+ = x + h f(t + h, x+, y+) + g dW + (1/2) sum_jk Dg_j g_k (dW_j dW_k - delta_jk h), 0 = u(t + h, x+, y+).

    D is the derivative along the solutions of the constraint: Dg_j z = dg_j/dx z - dg_j/dy (du/dy)^{-1} du/dx z, with
    g and its derivative at (t, x, y). The drift at the end of the step differs from that at its beginning by
    Df g dW + O(h), so that for commutative noise the defect of a step has the root mean square h^(3/2) and the mean
    h^2: strong and weak order 1. Otherwise the antisymmetric parts of the iterated integrals are missing, of
    root mean square h and mean 0: strong order 1/2. y solves the constraint at each mesh point and has the orders of
    x.

    A path on which Newton's method fails, or on which det du/dy changes its sign, keeps its state and is counted.
    """

    name: ClassVar[str] = "drift-implicit-milstein"
    form: ClassVar[type[IndexOneSDAE]] = IndexOneSDAE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source=PAPER),
        Claim(measure="strong", value=1.0, when=frozenset({"commutative-noise"}), source=f"{PAPER}; {LOCAL}"),
        Claim(measure="weak", value=1.0, source=f"{LOCAL}; Kloeden & Platen 1992, section 14.1"),
        Claim(measure="drift", value="round-off", when=frozenset({"algebraic"}), source="y solves the constraint"),
        STABLE,
    )
    source: ClassVar[str] = "Winkler 2004, J. Comput. Appl. Math. 163, 435; Kloeden & Platen 1992, section 12.2"

    def refuses(self, problem: IndexOneSDAE) -> str:
        """Refuse drifts and diffusions that complex steps cannot differentiate."""
        x, y = problem.initial(1)
        z, d = np.concatenate([x, y]), len(x)
        if reason := problem.why_not_jacobian():
            return reason
        analytic = is_analytic(lambda z: problem.diffusion(0.0, z[:d], z[:d], z[d:]), z)
        return "" if analytic else "diffusion is not analytic (abs or a real array?), so that it has no derivative"

    def step(self, problem: IndexOneSDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (x, y), d = state, problem.dimension
        kick = problem.diffused(t, x, x, y, noise.dW) + milstein_term(problem, state, t, h, noise.dW)
        guess = DelayState(x + h * problem.drift(t, x, x, y) + kick, y)
        begun = Begun(problem.lag(x, h, noise), x + kick, guess)
        root = solve_coupled(problem, begun, t + h, h)
        new = DelayState(root.x[:d], root.x[d:])
        sound = root.converged & regular(problem, begun.lag, (t, t + h), state, new)
        return hold_failed(state, new, root._replace(converged=sound))


def milstein_term(problem: IndexOneSDAE, state: DelayState, t: float, h: float, dW: Array) -> Array:
    """Return (1/2) sum_jk Dg_j g_k (dW_j dW_k - delta_jk h), shape (d, P).

    Parameters
    ----------
    problem : IndexOneSDAE
        Problem with an analytic diffusion.
    state : DelayState
        State at the beginning of the step.
    t : float
        Time at the beginning of the step.
    h : float
        Step size.
    dW : ndarray, shape (l, P)
        Increments of the Brownian motions.
    """
    (x, y), d = state, problem.dimension
    g = np.broadcast_to(problem.diffusion(t, x, x, y), (d, len(dW), x.shape[1]))
    term, z, products = np.zeros_like(x), np.concatenate([x, y]), dW[:, None] * dW
    products = products - h * np.eye(len(dW))[..., None]
    for k, column in enumerate(np.moveaxis(g, 1, 0)):
        along = np.concatenate([column, follow(problem, state, t, column)])
        Dg = directional(lambda w: problem.diffusion(t, w[:d], w[:d], w[d:]), z, along)
        term += 0.5 * (Dg * products[k]).sum(axis=1)
    return term


def follow(problem: IndexOneSDAE, state: DelayState, t: float, z: Array) -> Array:
    """Return the derivative of y along x in a direction z: -(du/dy)^{-1} du/dx z, shape (q, P).

    Parameters
    ----------
    problem : IndexOneSDAE
        Problem with or without constraint.
    state : DelayState
        State at which the derivatives are evaluated.
    t : float
        Time of the state.
    z : ndarray, shape (d, P)
        Direction.
    """
    if problem.constraint is None:
        return z[:0]
    du = problem.linearised_constraint(t, state.x, state.x, state.y)
    return -solve(du.y, np.einsum("qdp,dp->qp", du.x, z))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [DriftImplicitMilstein()]
