"""Trivial equations with a delay and with algebraic components."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...arrays import Array, Parts
from ..trivial import NOISES, RATE, SHORTER, SOURCE, H, Trivial, Trivials

# Delays, in steps: between mesh points, on one, within a step, and none.
DELAYS = (2.7, 2.0, 0.3, 0.0)
# One that stays where steps get shorter, so that a lagged value in the drift counts, and by how much they do then.
LONG, LESS_SHORT = 10.7 * H, 2.0**-10
# Rates and strengths of what vanishes on the solution; unlike, so that a lagged value in both of them stays.
PULL, TIE = 0.8, 0.5


def trivial_delays(form: Callable[..., Any]) -> Trivials:
    """Return dx = 0, dx = c dt and dx = S dW with lagged values of every kind as problems of the form."""
    noise, none = (NOISES[1], NOISES[2]), tuple(np.zeros_like(S) for S in NOISES[1:])
    equations = [(0.0 * RATE, none), (RATE, none), (0.0 * RATE, noise)]
    on_few_steps = [
        tuple(_on_both(form, steps, c, S, algebraic=algebraic) for S in strengths for algebraic in (True, False))
        for steps in DELAYS
        for c, strengths in equations
    ]
    long = (_delayed(form, LONG, RATE, S, algebraic=algebraic) for S in none for algebraic in (True, False))
    return *on_few_steps, tuple(trivial._replace(shorter=LESS_SHORT) for trivial in long)


def _on_both(form: Callable[..., Any], steps: float, c: Array, S: Array, *, algebraic: bool) -> Trivial:
    coarse, fine = (_delayed(form, steps * h, c, S, algebraic=algebraic) for h in (H, H * SHORTER))
    return coarse._replace(finer=fine)


def _delayed(form: Callable[..., Any], tau: float, c: Array, S: Array, *, algebraic: bool) -> Trivial:
    """Return x moving at the velocity c, or by noise, and y that follows its past or, by noise, x itself.

    Where x moves at the velocity c, all else that coefficients hold vanishes if lagged values are right.
    """
    start, follows = np.array([1.0, -0.5]), not S.any()
    given: dict[str, Any] = {"constraint": _lags(follows), "algebraic": start - tau * c} if algebraic else {}

    def behind(x: Array, v: Array) -> Array:
        return np.asarray(v - x + tau * c[:, None]) if follows else 0.0 * x

    def drift(_t: float, x: Array, v: Array, y: Array) -> Array:
        tie = y - (v if follows else x) if algebraic else 0.0
        return np.asarray(c[:, None] + PULL * behind(x, v) + TIE * tie)

    def solution(t: float, W: Array) -> Parts:
        x = start[:, None] + t * c[:, None] + S @ W
        return {"x": x, "y": x - tau * c[:, None]} if algebraic else {"x": x}

    problem = form(
        drift=drift,
        diffusion=lambda _t, x, v, _y: S[..., None] + PULL * behind(x, v)[:, None],
        delay=tau,
        history=lambda t: start + t * c,
        **given,
        noise_dim=S.shape[1],
        horizon=1.0,
        traits=frozenset({"additive-noise"} if not follows else set()),
        source=SOURCE,
    )
    equation = "dx = S dW" if S.any() else "dx = c dt" if c.any() else "dx = 0"
    follower = (", y = x(t - tau)" if follows else ", y = x") if algebraic else ""
    return Trivial(equation + follower, problem, solution)


def _lags(follows: bool) -> Callable[[float, Array, Array, Array], Array]:
    return lambda _t, x, v, y: y - (v if follows else x)
