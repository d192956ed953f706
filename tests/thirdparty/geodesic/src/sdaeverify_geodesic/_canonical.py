"""Whether a constrained problem is canonical Langevin dynamics, and with which friction.

It is asked at a few states: at the start, and near it on the manifold. With the projection Q onto the tangent space,

    Q M^{-1} [a(r, v) - a(r, 0)] = -gamma v,      Q M^{-1} B B^T v = s^2 v

have to hold for all tangent v, with the same numbers gamma and s at all positions and times.
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, ConstraintJacobian, HolonomicSDAE
from sdaeverify.numerics import apply, apply_transposed, norm

# How far the probes lie from the start, in units of its size, and the speeds there.
SHIFTS, SPEEDS = np.array([0.0, 0.1, -0.2, 0.3]), np.array([1.0, -2.0, 0.5, 1.5])
RELATIVE = 1e-9


class Canonical(NamedTuple):
    """What was found.

    Attributes
    ----------
    gamma : float
        Rate of the friction, unit 1/time.
    reason : str
        Why the problem is not canonical Langevin dynamics; empty if it is.
    """

    gamma: float
    reason: str = ""


def canonical(problem: HolonomicSDAE) -> Canonical:
    """Return the friction of a problem, or why the splitting cannot serve it."""
    r, v, J = _probes(problem)
    half = 0.5 * problem.horizon
    rest = _force(problem, J, (0.0, r, 0.0 * v))
    gamma = _factor(rest - _force(problem, J, (0.0, r, v)), v)
    if gamma is None or not _alike(rest, _force(problem, J, (half, r, 0.0 * v))):
        return Canonical(0.0, "its force is not a(r) - gamma v with one number gamma")
    noise = _covariance(problem, J, (0.0, r, 0.0 * v), v)
    if not all(_alike(noise, _covariance(problem, J, at, v)) for at in ((0.0, r, v), (half, r, 0.0 * v))):
        return Canonical(gamma, "its noise depends on the velocity or on time")
    if _factor(noise, v) is None:
        return Canonical(gamma, "its noise is not isotropic on the tangent space")
    return Canonical(gamma)


def _probes(problem: HolonomicSDAE) -> tuple[Array, Array, ConstraintJacobian]:
    n, m = problem.dimension, problem.constraints
    start = np.asarray(problem.position)
    # A bend of all coordinates that favours none.
    bend = np.sin(np.arange(1.0, n + 1))[:, None]
    r = start[:, None] + np.maximum(1.0, norm(start[:, None])) * SHIFTS / np.sqrt(n) * bend
    v = SPEEDS * np.cos(np.arange(1.0, n + 1)[:, None] * np.arange(1.0, len(SPEEDS) + 1))
    with np.errstate(all="ignore"):
        x = problem.admissible(np.concatenate([r, v, np.zeros((m, len(SPEEDS)))]))
    r, v, _ = problem.state(x[:, np.isfinite(x).all(axis=0)])
    return r, v, problem.linearised(r)


def _force(problem: HolonomicSDAE, J: ConstraintJacobian, at: tuple[float, Array, Array]) -> Array:
    a = np.broadcast_to(problem.force(*at), at[1].shape)
    return problem.tangent(J, problem.inverse_mass(a))[0]


def _covariance(problem: HolonomicSDAE, J: ConstraintJacobian, at: tuple[float, Array, Array], v: Array) -> Array:
    B = problem.diffusion(*at)
    return problem.tangent(J, problem.inverse_mass(apply(B, apply_transposed(B, v))))[0]


def _factor(image: Array, v: Array) -> float | None:
    """Return the one number c with image = c v on all paths, if there is one."""
    c = float((image * v).sum() / (v * v).sum())
    return c if _alike(image, c * v) else None


def _alike(x: Array, y: Array) -> bool:
    return bool(np.abs(x - y).max() <= RELATIVE * max(1.0, np.abs(x).max()))
