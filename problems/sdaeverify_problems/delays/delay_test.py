"""The test problem of Qu, Huang & Liu (2010), (5.1), with its six sets of coefficients or any others."""

from math import isnan, nan

import numpy as np

from sdaeverify import DelaySDAE, Partials, hookimpl

from .._arguments import check_choice
from .._known import matrix, monomials
from ._coefficients import SETS, Coefficients
from ._test_moments import moments

SOURCE = "Qu, Huang & Liu 2010, (5.1)"


def delay_test(  # noqa: PLR0913, PLR0917 - the paper's six coefficients
    set: str = "IV",  # noqa: A002 - the paper's word
    a: float = nan,
    b: float = nan,
    c: float = nan,
    d: float = nan,
    l: float = nan,
    q: float = nan,
    horizon: float = 4.0,
) -> DelaySDAE:
    """Linear but for a sine: dx = [a x + b v + y] dt + [c x + d v] dW, 0 = l sin v + q x - y, v(t) = x(t - 1).

    x(t) = t + 1 on [-1, 0]. Eliminating y gives dx = [A x + b v + l sin v] dt + [c x + d v] dW, A = a + q.

    Parameters
    ----------
    set : str
        Set of coefficients in the paper, ``I`` to ``VI``.
    a : float
        Replaces the value of the set if given, as all other coefficients; unit 1/time.
    b : float
        Unit 1/time.
    c : float
        Unit 1/sqrt(time).
    d : float
        Unit 1/sqrt(time).
    l : float
        Unit 1/time.
    q : float
        Unit 1/time.
    horizon : float
        Final time, the delay being 1.

    Source
    ------
    Qu, Huang & Liu (2010), section 5.
    """
    check_choice("set", set, SETS)
    given = (a, b, c, d, l, q)
    at = Coefficients(*(own if isnan(value) else value for value, own in zip(given, SETS[set], strict=True)))
    return problem(at, horizon)


def problem(at: Coefficients, horizon: float) -> DelaySDAE:
    """Return the problem with the given coefficients."""
    a, b, c, d, l, q = at

    return DelaySDAE(
        drift=lambda t, x, v, y: a * x + b * v + y,
        diffusion=lambda t, x, v, y: (c * x + d * v)[:, None],
        constraint=lambda t, x, v, y: l * np.sin(v) + q * x - y,
        solved=lambda t, x, v: l * np.sin(v) + q * x,
        drift_partials=lambda t, x, v, y: Partials(matrix(a, x), matrix(b, x), matrix(1.0, x)),
        constraint_partials=lambda t, x, v, y: Partials(matrix(q, x), l * np.cos(v)[None], matrix(-1.0, x)),
        delay=1.0,
        history=lambda t: [t + 1.0],
        algebraic=[q],
        noise_dim=1,
        noise=frozenset({"dW"}),
        horizon=horizon,
        traits=frozenset({"delayed-noise"} if c == 0.0 else set()),
        observables=monomials("x", "x^2", "x^3", "y"),
        truths=moments(at, horizon),
        dissipation=at.dissipation,
        dissipation_without_y=at.dissipation_without_y,
        units="x dimensionless, time in the unit of the delay",
        source=SOURCE,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [delay_test]
