"""Trivial motions with a constraint."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...arrays import Array, Parts
from ..trivial import NOISES, RATE, SOURCE, SPEED, Trivial, Trivials


def trivial_motions(form: Callable[..., Any]) -> Trivials:
    """Return rest, free motion and motion driven by noise on the line r_2 = 0 as problems of the form."""
    still = [_on_a_line(form, "r at rest on r_2 = 0", 0.0, 0.0 * RATE, 0.0 * S) for S in NOISES]
    free = [_on_a_line(form, "free motion on r_2 = 0", SPEED, 0.0 * RATE, 0.0 * S) for S in NOISES]
    kicked = [_on_a_line(form, "dv = c dt + S dW on r_2 = 0", SPEED, RATE, S, known=("v",)) for S in NOISES]
    return tuple(still), tuple(free), tuple(kicked)


def _on_a_line(
    form: Callable[..., Any], name: str, speed: float, a: Array, S: Array, known: tuple[str, ...] = ("r", "v", "mu")
) -> Trivial:
    start = np.array([0.3, 0.0])
    problem = form(
        force=lambda _t, r, _v: a[:, None] + 0.0 * r,
        diffusion=lambda _t, r, _v: S[..., None] + 0.0 * r[:1, None],
        constraint=lambda r: r[1:],
        jacobian=lambda r: np.array([[[0.0], [1.0]]]) + 0.0 * r[:1],
        curvature=lambda _r, y, _z: 0.0 * y[1:],
        constraint_bound=1.0,
        position=start,
        velocity=[speed, 0.0],
        noise_dim=S.shape[1],
        horizon=1.0,
        traits=frozenset({"additive-noise"}),
        source=SOURCE,
    )
    along = np.array([[1.0], [0.0]])

    def solution(t: float, W: Array) -> Parts:
        v = along * (speed + t * a[0] + S[:1] @ W)
        parts = {"r": start[:, None] + t * v, "v": v, "mu": 0.0 * W[:1]}
        return {key: parts[key] for key in known}

    return Trivial(name, problem, solution)
