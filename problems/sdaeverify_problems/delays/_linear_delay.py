"""Problems of a scalar linear delay equation, with the mean and the second moment of their solution."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sdaeverify import DelaySDAE, Moment, Partials

from .._known import matrix, moments, monomials
from ._renewal_equation import mean, second, size
from ._scalar_delay import ScalarDelay

MOMENTS = "variation of constants and its renewal equation"
# Maximal number of unknowns for moments, about 2000 delays unless the equation is stiff: three seconds of
# computation.
MOST_UNKNOWNS = 40_100
OBSERVABLES = monomials("x", "x^2", "x^3")


def linear_delay(equation: ScalarDelay, *, horizon: float, truths: tuple[Any, ...] = (), **further: Any) -> DelaySDAE:
    """Return the problem dx = (A x + B v) dt + (c x + d v + s) dW without y.

    Parameters
    ----------
    equation : ScalarDelay
    horizon : float
    truths : tuple of Truth, optional
        Truths in addition to the moments.
    **further
        Additional fields of the problem.

    Returns
    -------
    DelaySDAE
    """
    A, B, c, d, s, tau, *_ = equation

    fields: Mapping[str, Any] = {"noise": frozenset({"dW"}), "observables": OBSERVABLES, **further}
    return DelaySDAE(
        drift=lambda t, x, v, y: A * x + B * v,
        diffusion=lambda t, x, v, y: (c * x + d * v + s)[:, None],
        drift_partials=lambda t, x, v, y: Partials(matrix(A, x), matrix(B, x), np.zeros((1, 0, x.shape[-1]))),
        delay=tau,
        history=lambda t: [equation.past(t)],
        noise_dim=1,
        horizon=horizon,
        truths=(*delay_moments(equation, horizon), *truths),
        **fields,
    )


def delay_moments(equation: ScalarDelay, horizon: float) -> tuple[Moment, ...]:
    """Return E x and E x^2, or an empty tuple if the horizon needs more than `MOST_UNKNOWNS` unknowns."""
    if size(equation, horizon) > MOST_UNKNOWNS:
        return ()
    return moments({"x": lambda t: mean(equation, t), "x^2": lambda t: second(equation, t)}, MOMENTS)
