"""A constrained problem seen as its inherent SDE, Lindner & Stroot (2017), (2.9)."""

from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ..sde.sde import SDE, zero_columns

if TYPE_CHECKING:
    from .holonomic import HolonomicSDAE
    from .jacobian import ConstraintJacobian


def inherent_sde(problem: "HolonomicSDAE", *, with_multiplier: bool = False) -> SDE:
    """Eliminate the multiplier.

    With the Gram matrix G_M = Dg M^{-1} grad g and the projector P_M = Id - grad g G_M^{-1} Dg M^{-1},

        dr   = v dt
        M dv = [ P_M a - grad g G_M^{-1} D^2 g(v, v) ] dt + P_M B dw                                   (2.9)
        dmu  = -G_M^{-1} { [ Dg M^{-1} a + D^2 g(v, v) ] dt + Dg M^{-1} B dw }                         (2.8)

    taken with the actual Dg(r) and G_M(r) off the manifold as well. The state is (r, v), shape (2 n, P).

    Parameters
    ----------
    problem : HolonomicSDAE
    with_multiplier : bool
        Whether mu is a component, too, of a state (r, v, mu), shape (2 n + m, P).

    Returns
    -------
    SDE
    """
    n, m = problem.dimension, problem.constraints if with_multiplier else 0

    def drift(t: float, x: Array) -> Array:
        r, v = x[:n], x[n : 2 * n]
        J = problem.linearised(r)
        a = np.broadcast_to(problem.force(t, r, v), r.shape)
        lam = problem.inherent_multiplier(J, r, v, a)
        return np.concatenate([v, problem.inverse_mass(a + J.transposed(lam)), lam[:m]])

    def diffusion(t: float, x: Array) -> Array:
        r, v = x[:n], x[n : 2 * n]
        PB, Lam = projected(problem, problem.linearised(r), problem.diffusion(t, r, v))
        return zero_columns(np.concatenate([problem.inverse_mass(PB), Lam[:m]]), n)

    def diffusion_product(t: float, x: Array, w: Array) -> Array:
        r, v = x[:n], x[n : 2 * n]
        Pw, lam = projected(problem, problem.linearised(r), problem.diffused(t, r, v, w))
        return np.concatenate([0.0 * r, problem.inverse_mass(Pw), lam[:m]])

    start = [np.asarray(problem.position), np.asarray(problem.velocity), np.zeros(m)]
    names = {"r": slice(0, n), "v": slice(n, 2 * n), "mu": slice(2 * n, None)}
    return SDE(
        drift=drift,
        diffusion=diffusion,
        diffusion_product=diffusion_product,
        start=np.concatenate(start),
        names=names if with_multiplier else {name: names[name] for name in ("r", "v")},
        horizon=problem.horizon,
        noise_dim=problem.noise_dim,
        noise=problem.noise,
        source=f"inherent SDE (Lindner & Stroot 2017, (2.9)) of: {problem.source}",
        units=problem.units,
        traits=problem.traits - {"additive-noise", "diagonal-noise"},
        observables=problem.observables,
        truths=problem.truths,
        seen_as="inherent SDE",
    )


def projected(problem: "HolonomicSDAE", J: "ConstraintJacobian", y: Array) -> tuple[Array, Array]:
    """Return P_M y and the multipliers -G_M^{-1} Dg M^{-1} y that make it up, for y of shape (n, P) or (n, l, P)."""
    # y may be constant on all paths; what is taken from it is not.
    lam = -J.gram(J).solve(J.times(problem.inverse_mass(y)))
    return y + J.transposed(lam), lam
