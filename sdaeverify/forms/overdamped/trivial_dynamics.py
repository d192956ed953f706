"""Overdamped dynamics on planes and near them that every scheme for the form solves exactly, or to first order.

With an affine constraint g^T (x - x_0), g constant, grad ln det G and div g vanish. In the limit eps = 0

    X = x_0 + Pi (c t + sigma W)

is the result of every projection. For eps > 0 the same holds for rest and for a drift along the planes. With noise,
the penalty changes X by a part of size t/eps. So a step is exact to first order only, and an error that does not
vanish with the step is a defect of the scheme.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array, Parts
from ...noise.brownian import BROWNIAN
from ..trivial import NORMALS, SOURCE, WIDE_NORMALS, WIDE_RATE, WIDE_START, Trivial, Trivials

STRENGTH = 0.7


class Dynamics(NamedTuple):
    """Dynamics with constant coefficients.

    Attributes
    ----------
    name : str
    eps : float
    normals : ndarray, shape (q, d)
        g^T.
    moves : bool
        Whether there is a drift.
    strength : float
        sigma.
    """

    name: str
    eps: float
    normals: Array
    moves: bool = False
    strength: float = 0.0


def trivial_dynamics(form: Callable[..., Any]) -> Trivials:
    """Return the problems of rest, drift and noise on one plane and on the intersection of several, and near it.

    Parameters
    ----------
    form : callable
        Constructor of the problem: `ConstrainedLangevin`.
    """
    dynamics = (
        Dynamics("x at rest on a plane", 0.0, NORMALS[:1]),
        Dynamics("dX = Pi c dt on a plane", 0.0, NORMALS[:1], True),
        Dynamics("dX = Pi (c dt + sigma dW) on a plane", 0.0, NORMALS[:1], True, STRENGTH),
        Dynamics("dX = Pi (c dt + sigma dW) on two planes", 0.0, NORMALS, True, STRENGTH),
        Dynamics("x at rest near two planes", 1.0, NORMALS),
        Dynamics("dX = Pi c dt near two planes", 1.0, NORMALS, True),
        Dynamics("dX = Pi c dt + sigma dW near two planes", 1.0, NORMALS, True, STRENGTH),
        Dynamics("dX = Pi (c dt + sigma dW) on three planes", 0.0, WIDE_NORMALS, True, STRENGTH),
        Dynamics("dX = Pi c dt + sigma dW near three planes", 1.0, WIDE_NORMALS, True, STRENGTH),
    )
    return tuple((_make_trivial(form, each),) for each in dynamics)


def _make_trivial(form: Callable[..., Any], dynamics: Dynamics) -> Trivial:
    J, sigma, d = dynamics.normals, dynamics.strength, dynamics.normals.shape[1]
    start = WIDE_START[:d]
    Pi = np.eye(d) - J.T @ np.linalg.solve(J @ J.T, J)
    c = dynamics.moves * (Pi @ WIDE_RATE[:d] if dynamics.eps else WIDE_RATE[:d])
    spread = sigma * (np.eye(d) if dynamics.eps else Pi)
    problem = form(
        drift=lambda x: c[:, None] + 0.0 * x,
        strength=sigma,
        eps=dynamics.eps,
        constraint=lambda x: J @ (x - start[:, None]),
        jacobian=lambda x: J[..., None] + 0.0 * x[:1],
        hessians=np.zeros((len(J), d, d)),
        start=start,
        noise=frozenset(BROWNIAN),
        horizon=1.0,
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        return {"x": start[:, None] + t * (Pi @ c)[:, None] + spread @ W}

    return Trivial(dynamics.name, problem, solution)
