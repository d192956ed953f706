"""Constrained motions that every scheme for mechanics solves exactly: constant force and noise, affine constraints.

With g(r) = J (r - r_0), constant M, a and B, and Q = Id - M^{-1} J^T (J M^{-1} J^T)^{-1} J,

    v(t) = v_0 + Q M^{-1} (a t + B w(t)),

and J v = 0 determines the sum of all multipliers of a step, wherever a scheme evaluates normals and projectors. So v
is exact for half-explicit, semi-implicit, explicit and implicit (GGL) Euler steps; r is exact only if v is constant.
The problems are ordered from few features to many, and each name lists its features: the first failure shows the
cause.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, Parts
from ...noise.brownian import BROWNIAN
from ..trivial import (
    NOISES,
    NORMALS,
    SOURCE,
    SPEED,
    WIDE,
    WIDE_NOISE,
    WIDE_NORMALS,
    WIDE_RATE,
    WIDE_START,
    Trivial,
    Trivials,
)

MASS = np.array([[1.2, 0.3, -0.2, 0.1], [0.3, 0.8, 0.2, -0.2], [-0.2, 0.2, 1.5, 0.4], [0.1, -0.2, 0.4, 0.9]])
# Nearly infinite, but with a mass of 1 still positive definite beyond rounding; 2^-50 of a force has no effect.
HEAVY = np.diag([2.0**50, 1.0])
WIDE_MASS = np.eye(WIDE) + 0.1 * WIDE_NOISE @ WIDE_NOISE.T
FORCE = WIDE_RATE
NOISE = np.array([[0.7, -0.3], [0.2, 0.9], [-0.5, 0.4], [0.6, 0.3]])
# An upper bound of all norms of Lindner & Stroot (2017), (2.7), for all of these problems; the largest is 2.2.
BOUND = 2.5
LINE, TIE = np.array([[0.0, 1.0]]), np.array([[-1.0, 1.0]])
STATE, VELOCITY = ("r", "v", "mu"), ("v",)


class Motion(NamedTuple):
    """A body that moves with constant coefficients.

    Attributes
    ----------
    name : str
    J : ndarray, shape (m, n)
        Jacobian of the constraint.
    M : ndarray, shape (n, n), or None
        Mass matrix.
    pushed : bool
        Whether there are a force and noise.
    known : tuple of str
        Components with an exact solution; mu is known unless the body is pushed.
    speed : float
        Initial speed.
    bound : float
        C_g.
    """

    name: str
    J: Array
    M: Array | None
    pushed: bool
    known: tuple[str, ...]
    speed: float = SPEED
    bound: float = BOUND

    @property
    def start(self) -> Array:
        """Initial position, shape (n,)."""
        start = WIDE_START[: self.J.shape[1]].copy()
        if self.J is LINE:
            start[1] = 0.0
        return start

    @property
    def tangent(self) -> Array:
        """The projector Q, shape (n, n)."""
        normals = self.J.T if self.M is None else np.linalg.solve(self.M, self.J.T)
        return np.asarray(np.eye(len(normals)) - normals @ np.linalg.solve(self.J @ normals, self.J))


def trivial_motions(form: Callable[..., Any]) -> Trivials:
    """Return the problems of rest, free motion and motion under constant force and noise, for several masses.

    Parameters
    ----------
    form : callable
        Constructor of the problem: `HolonomicSDAE`.
    """
    motions = (
        Motion("r at rest on r_2 = 0", LINE, None, False, STATE, 0.0, 1.0),
        Motion("free motion on r_2 = 0", LINE, None, False, STATE, bound=1.0),
        Motion("dv = c dt + S dW on r_2 = 0", LINE, None, True, VELOCITY, bound=1.0),
        Motion("M dv = c dt + S dW, M full", NORMALS[:1], MASS, True, VELOCITY),
        Motion("dv = c dt + S dW, two constraints", NORMALS, None, True, VELOCITY),
        Motion("M dv = c dt + S dW, M full, two constraints", NORMALS, MASS, True, VELOCITY),
        Motion("free motion, M full, two constraints", NORMALS, MASS, False, STATE),
        Motion("dv = 0, a mass almost infinite", TIE, HEAVY, True, ("r", "v")),
        Motion("M dv = c dt + S dW, M full, three constraints", WIDE_NORMALS, WIDE_MASS, True, VELOCITY),
    )
    return tuple(tuple(_make_trivial(form, motion, S) for S in _strengths(motion)) for motion in motions)


def _strengths(motion: Motion) -> tuple[Array, ...]:
    """Return noise matrices with two motions and with one; in the plane also a diagonal matrix."""
    if motion.J.shape[1] == WIDE:
        return WIDE_NOISE, WIDE_NOISE[:, :1]
    return NOISES if motion.J.shape[1] == 2 else (NOISE, NOISE[:, :1])


def _make_trivial(form: Callable[..., Any], motion: Motion, strength: Array) -> Trivial:
    (J, M), start = (motion.J, motion.M), motion.start
    a, S = motion.pushed * FORCE[: len(start)], motion.pushed * strength
    moved = motion.tangent if M is None else motion.tangent @ np.linalg.inv(M)
    along = motion.tangent[:, 0]
    v_0 = motion.speed * along / np.linalg.norm(along)
    problem = form(
        mass=M,
        force=lambda _t, r, _v: a[:, None] + 0.0 * r,
        diffusion=lambda _t, r, _v: S[..., None] + 0.0 * r[:1, None],
        constraint=lambda r: J @ (r - start[:, None]),
        jacobian=lambda r: J[..., None] + 0.0 * r[:1],
        curvature=lambda _r, y, _z: 0.0 * y[: len(J)],
        constraint_bound=motion.bound,
        position=start,
        velocity=v_0,
        noise_dim=S.shape[1],
        noise=frozenset(BROWNIAN),
        horizon=1.0,
        traits=frozenset({"additive-noise"}),
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        v = v_0[:, None] + moved @ (t * a[:, None] + S @ W)
        parts = {"r": start[:, None] + t * v, "v": v, "mu": np.zeros((len(J), W.shape[1]))}
        return {key: parts[key] for key in motion.known}

    return Trivial(motion.name, problem, solution)
