"""Mistakes in masses, Gram matrices and curvature, and the equations that they make of those of a form.

A mistake is a change of one part of the equation that a form solves for its multipliers. On a random member no two of
them have the same drift and covariance.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ...arrays import Array
from ...numerics.linalg import Dense

WHOLE, DIAGONAL, LEFT_OUT, MASSLESS = "whole", "diagonal", "left out", "without mass"


@dataclass(frozen=True)
class MotionMistake:
    """A mistake in dr = v dt, dv = du + K_g grad g dmu with du = K_a a dt + K_B B dw.

    The multiplier is dmu = -S (Dg du + k D^2 g(v, v) dt).

    Attributes
    ----------
    sentence : str
    force, noise, push : bool
        Whether K_a, K_B and K_g are M^{-1}, as they are meant, or the identity.
    gram : str
        What S is the inverse of: Dg M^{-1} grad g ``whole``, its ``diagonal``, or Dg grad g, ``without mass``.
    curvature : float
        k.
    """

    sentence: str
    force: bool = True
    noise: bool = True
    push: bool = True
    gram: str = WHOLE
    curvature: float = 1.0

    def coefficients(self, problem: Any, t: float, x: Array) -> tuple[Array, Array]:
        """Return the drift, shape (d, P), and the diffusion, shape (d, l, P), that the mistake makes of a problem.

        Parameters
        ----------
        problem : HolonomicSDAE
        t : float
        x : ndarray, shape (d, P)
            States.
        """
        n = problem.dimension
        r, v = x[:n], x[n : 2 * n]
        a = np.broadcast_to(problem.force(t, r, v), r.shape)
        B = np.broadcast_to(problem.diffusion(t, r, v), (n, problem.noise_dim, r.shape[1]))
        a, B = (problem.inverse_mass(y) if has else y for y, has in ((a, self.force), (B, self.noise)))
        Dg = np.broadcast_to(problem.dg(r), (problem.constraints, *r.shape))
        pushed = np.swapaxes(Dg, 0, 1)
        bent = self.curvature * problem.d2g(r, v, v)
        G = np.einsum("inp,njp->ijp", Dg, pushed if self.gram == MASSLESS else problem.inverse_mass(pushed))
        lam = -_solved(G, np.einsum("inp,np->ip", Dg, a) + bent, self.gram)
        Lam = -_solved(G, np.einsum("inp,nlp->ilp", Dg, B), self.gram)
        N = problem.inverse_mass(pushed) if self.push else pushed
        f = np.concatenate([v, a + np.einsum("nip,ip->np", N, lam), lam])
        C = np.concatenate([0.0 * B, B + np.einsum("nip,ilp->nlp", N, Lam), Lam])
        return f[: len(x)], C[: len(x)]


@dataclass(frozen=True)
class DynamicsMistake:
    """A mistake in the dynamics near or on a manifold, with S in place of G^{-1}.

    On it dX = Pi f dt - k (sigma^2/2) g S tau dt + sigma Pi dW with Pi = Id - g S g^T, and near it
    dX = f dt + k (sigma^2/4) grad ln det G dt - g S zeta/eps dt + sigma dW.

    Attributes
    ----------
    sentence : str
    kept : bool
        Whether it is one on the manifold.
    gram : str
        What S is the inverse of: G ``whole``, its ``diagonal``, or the identity, ``left out``.
    curvature : float
        k.
    drift : bool
        Whether f is projected on the manifold, as it is meant.
    """

    sentence: str
    kept: bool
    gram: str = WHOLE
    curvature: float = 1.0
    drift: bool = True

    def coefficients(self, problem: Any, t: float, x: Array) -> tuple[Array, Array]:  # noqa: ARG002 - of every form
        """Return the drift, shape (d, P), and the diffusion, shape (d, d, P), that the mistake makes of a problem.

        Parameters
        ----------
        problem : ConstrainedLangevin
        t : float
        x : ndarray, shape (d, P)
            States.
        """
        sigma, at, f = problem.strength, problem.near(x), np.broadcast_to(problem.drift(x), x.shape)
        Dg = np.broadcast_to(problem.dg(x), (problem.constraints, *x.shape))
        solved = partial(_solved, np.einsum("inp,jnp->ijp", Dg, Dg), how=self.gram)
        N = np.einsum("inp,ikp->nkp", Dg, solved(Dg)) if self.kept else np.zeros((len(x), *x.shape))
        Pi = np.eye(len(x))[..., None] - N
        if not self.kept:
            back = np.einsum("inp,ip->np", Dg, solved(at.zeta)) / problem.eps
            return f + 0.25 * self.curvature * sigma**2 * at.fixman - back, sigma * Pi
        # tr (Pi H_k): the traces without those along the normals.
        turned = np.stack([problem.turn_normals(x, column) for column in np.swapaxes(N, 0, 1)])
        tau = at.divergence - np.einsum("jkjp->kp", turned)
        moved = np.einsum("nkp,kp->np", Pi, f) if self.drift else f
        bent = np.einsum("inp,ip->np", Dg, solved(tau))
        return moved - 0.5 * self.curvature * sigma**2 * bent, sigma * Pi


def _solved(G: Array, b: Array, how: str) -> Array:
    """Return S b for b of shape (m, P) or (m, k, P), S being the inverse of G, of its diagonal, or the identity."""
    if how == LEFT_OUT:
        return b
    return Dense(G * np.eye(len(G))[..., None] if how == DIAGONAL else G).solve(b)


OUT = "is left out, M^-1 is meant"
MOTION_MISTAKES = (
    MotionMistake(f"the mass matrix {OUT}: a dt + B dw moves the velocity", force=False, noise=False),
    MotionMistake(f"the mass matrix {OUT} in front of the force", force=False),
    MotionMistake(f"the mass matrix {OUT} in front of the noise", noise=False),
    MotionMistake(f"the mass matrix {OUT} in the constraint forces M^-1 grad g mu", push=False),
    MotionMistake(f"the mass matrix {OUT} in the Gram matrix Dg M^-1 grad g", gram=MASSLESS),
    MotionMistake(f"the mass matrix {OUT} in constraint forces and Gram matrix", push=False, gram=MASSLESS),
    MotionMistake(f"the mass matrix {OUT} everywhere", force=False, noise=False, push=False, gram=MASSLESS),
    MotionMistake(
        "the Gram matrix is cut to its diagonal: each constraint is kept as if it were alone", gram=DIAGONAL
    ),
    MotionMistake(
        "the curvature term D^2 g(v, v) is left out: velocities go onto the tangent space of the old position",
        curvature=0.0,
    ),
    MotionMistake("the curvature term D^2 g(v, v) has the wrong sign", curvature=-1.0),
    MotionMistake("the curvature term D^2 g(v, v) is halved", curvature=0.5),
    MotionMistake("the curvature term D^2 g(v, v) is doubled", curvature=2.0),
)
CURVED, FIXMAN = "the curvature term (sigma^2/2) g G^-1 tau", "the term (sigma^2/4) grad ln det G"
KEPT_MISTAKES = (
    DynamicsMistake(f"{CURVED} is left out: the noise is projected in Ito's sense", True, curvature=0.0),
    DynamicsMistake(f"{CURVED} has the wrong sign", True, curvature=-1.0),
    DynamicsMistake(f"{CURVED} is halved", True, curvature=0.5),
    DynamicsMistake(f"{CURVED} is doubled", True, curvature=2.0),
    DynamicsMistake("the Gram matrix is cut to its diagonal", True, gram=DIAGONAL),
    DynamicsMistake(
        "the Gram matrix is cut to its diagonal, and the curvature term is left out", True, DIAGONAL, 0.0
    ),
    DynamicsMistake("the drift is not projected onto the manifold", True, drift=False),
)
PENALISED_MISTAKES = (
    DynamicsMistake(f"{FIXMAN} is left out", False, curvature=0.0),
    DynamicsMistake(f"{FIXMAN} has the wrong sign", False, curvature=-1.0),
    DynamicsMistake(f"{FIXMAN} is halved", False, curvature=0.5),
    DynamicsMistake(f"{FIXMAN} is doubled", False, curvature=2.0),
    DynamicsMistake("the Gram matrix is cut to its diagonal in g G^-1 zeta/eps", False, DIAGONAL),
    DynamicsMistake("the Gram matrix is left out: g zeta/eps where g G^-1 zeta/eps is meant", False, LEFT_OUT),
)
