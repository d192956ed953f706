"""A constrained problem seen as its inherent SDE, Lindner & Stroot (2017), (2.9)."""

from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..numerics import apply, apply_transposed, solve
from .sde import SDE, zero_columns

if TYPE_CHECKING:
    from .holonomic import HolonomicSDAE


def inherent_sde(problem: "HolonomicSDAE") -> SDE:
    """Eliminate the multiplier.

    With the Gram matrix G_M = Dg M^{-1} grad g and the projector P_M = Id - grad g G_M^{-1} Dg M^{-1},

        dr   = v dt
        M dv = [ P_M a - grad g G_M^{-1} D^2 g(v, v) ] dt + P_M B dw                                   (2.9)

    taken with the actual Dg(r) and G_M(r) off the manifold as well. The state is (r, v), shape (2 n, P).

    Parameters
    ----------
    problem : HolonomicSDAE

    Returns
    -------
    SDE
    """
    n = problem.dimension

    def drift(t: float, x: Array) -> Array:
        r, v = x[:n], x[n:]
        a = np.broadcast_to(problem.force(t, r, v), r.shape)
        Dg = problem.dg(r)
        lam = problem.multiplier_of(Dg, r, v, a)
        return np.concatenate([v, problem.inverse_mass(a + apply_transposed(Dg, lam))])

    def diffusion(t: float, x: Array) -> Array:
        r, v = x[:n], x[n:]
        B = problem.diffusion(t, r, v)
        return zero_columns(problem.inverse_mass(projected(problem, r, B)), n)

    start = np.concatenate([np.asarray(problem.position), np.asarray(problem.velocity)])
    return SDE(
        drift=drift,
        diffusion=diffusion,
        start=start,
        names={"r": slice(0, n), "v": slice(n, None)},
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


def projected(problem: "HolonomicSDAE", r: Array, B: Array) -> Array:
    """Return P_M(r) B, shape (n, l, P)."""
    Dg = problem.dg(r)
    # B may be constant on all paths; what is taken from it is not.
    return B - apply_transposed(Dg, solve(problem.gram(Dg, Dg), apply(Dg, problem.inverse_mass(B))))
