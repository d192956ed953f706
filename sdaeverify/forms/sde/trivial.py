"""Trivial equations of the form dx = f dt + B dW."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...arrays import Array, Parts
from ..trivial import NOISES, RATE, SOURCE, Trivial, Trivials

# For schemes that ask for noise of the same strength in each component.
EVEN = 0.8 * np.eye(2)
# For schemes that ask for an invariant: x_2 = 0.
ALONG = np.array([[0.7, -0.3], [0.0, 0.0]])


def trivial_equations(form: Callable[..., Any]) -> Trivials:
    """Return dx = 0, dx = c dt and dx = S dW as problems of the form."""
    noises = (*NOISES, EVEN, ALONG)
    still, moving = [0.0 * S for S in noises], [*(RATE for _ in noises[1:]), RATE * [1.0, 0.0]]
    return (
        tuple(_sde(form, "dx = 0", 0.0 * RATE, S, invariant=S is still[-1]) for S in still),
        tuple(_sde(form, "dx = c dt", c, S, invariant=S is still[-1]) for c, S in zip(moving, still, strict=True)),
        tuple(_sde(form, "dx = S dW", 0.0 * RATE, S, invariant=S is ALONG) for S in noises),
    )


def _sde(form: Callable[..., Any], name: str, c: Array, S: Array, *, invariant: bool) -> Trivial:
    start, l = np.array([1.0, 0.0 if invariant else -0.5]), S.shape[1]
    diagonal = l == 2 and not (S - np.diag(np.diag(S))).any()
    problem = form(
        drift=lambda _t, x: c[:, None] + 0.0 * x,
        diffusion=lambda _t, x: S[..., None] + 0.0 * x[:1, None],
        diffusion_derivative=lambda _t, x, _y: np.zeros((2, l, x.shape[1])),
        constraint=(lambda x: x[1:]) if invariant else None,
        start=start,
        noise_dim=l,
        horizon=1.0,
        traits=frozenset({"additive-noise", "diagonal-noise"} if diagonal else {"additive-noise"}),
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        return {"x": start[:, None] + t * c[:, None] + S @ W}

    return Trivial(name, problem, solution)
