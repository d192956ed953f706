"""Trivial Langevin dynamics."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...arrays import Array, Parts
from ..trivial import SOURCE, SPEED, Trivial, Trivials

FRICTION = 0.5


def trivial_dynamics(form: Callable[..., Any]) -> Trivials:
    """Return rest, damped motion and motion driven by noise as problems of the form."""
    still = _damped(form, "q at rest", 0.0, 0.0, 0.0, ("q", "p"))
    coasting = _damped(form, "dp = -gamma p dt", SPEED, 0.0, 0.0, ("q", "p"))
    kicked = _damped(form, "dp = (c - gamma p) dt + sigma dW", SPEED, 0.4, 0.7, ("p",))
    return (still,), (coasting,), (kicked,)


def _damped(
    form: Callable[..., Any], name: str, speed: float, force: float, sigma: float, known: tuple[str, ...]
) -> Trivial:
    along, start = np.array([[1.0], [-0.5]]), np.array([0.3, 0.8])
    problem = form(
        force=lambda q: force * along + 0.0 * q,
        friction=FRICTION,
        strength=sigma,
        position=start,
        momentum=speed * along[:, 0],
        horizon=1.0,
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        decayed = -np.expm1(-FRICTION * t) / FRICTION
        p = along * (speed + decayed * (force - FRICTION * speed)) + sigma * W
        parts = {"q": start[:, None] + decayed * speed * along + 0.0 * W, "p": p}
        return {key: parts[key] for key in known}

    return Trivial(name, problem, solution)
