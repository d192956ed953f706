"""Random overdamped dynamics near or on level sets: polynomial drift and constraints."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ...arrays import Array
from ..generic import Generator, Polynomial, draw_polynomial, draw_regular, draw_signed, with_linear_part

COMPONENTS, CONSTRAINTS = 4, 2
STRENGTH, STIFFNESS = (0.6, 1.0), (0.2, 0.5)
DRIFT, SEVERAL, CURVED = "drift", "constraints", "curvature"
FEATURES = {
    DRIFT: "a drift that depends on the state",
    SEVERAL: "several constraints",
    CURVED: "curved constraints",
}
HORIZON = 0.5


def draw_family(form: Callable[..., Any], rng: Generator, without: frozenset[str], *, kept: bool) -> Any:
    """Draw a problem with all its stiffness parameters.

    Parameters
    ----------
    form : type
        `ConstrainedLangevin`.
    rng : numpy.random.Generator
    without : frozenset of str
        Names of features to omit.
    kept : bool
        Whether the constraints are exact: eps = 0.
    """
    d, q = COMPONENTS, 1 if SEVERAL in without else CONSTRAINTS
    x = 1.0 + draw_signed(rng, (d,))
    zeta = with_linear_part(draw_polynomial(rng, x, q), draw_regular(rng, q, d))
    f = draw_polynomial(rng, x, d)
    strength, eps = rng.uniform(*STRENGTH), rng.uniform(*STIFFNESS)
    zeta = zeta.up_to(1) if CURVED in without else zeta
    f = f.up_to(0) if DRIFT in without else f
    given = {
        "drift": f,
        "constraint": zeta,
        **_derivatives(zeta),
        "start": x,
        "strength": float(strength),
        "horizon": HORIZON,
        "source": "drawn at random",
        "observables": {"x_1": lambda _, s: s["x"][0], "|x|^2": lambda _, s: (s["x"] ** 2).sum(axis=0)},
    }

    def member(eps: float) -> Any:
        return form(**given, eps=eps, family=member)

    # Claims about all stiffness parameters are tested on the penalised class.
    return form(**given, eps=0.0) if kept else member(float(eps))


def _derivatives(zeta: Polynomial) -> dict[str, Any]:
    q, d = len(zeta.coefficients), len(zeta.centre)
    first = zeta.derivative
    H = partial(_shaped, first.derivative, (q, d, d))
    return {
        "jacobian": partial(_shaped, first, (q, d)),
        "second": lambda x, A: np.einsum("kijp,jkp->ip", H(x), A),
        "laplacians": lambda x: np.einsum("kiip->kp", H(x)),
    }


def _shaped(f: Polynomial, shape: tuple[int, ...], x: Array) -> Array:
    return f(x).reshape(*shape, -1)
