"""Orthonormal frames, the Stiefel manifold, or matrices near them, with no drift along the manifold."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Array, ConstrainedLangevin, ParameterError, Parts, Truth, hookimpl, on_request

from .. import _controls as controls
from .._arguments import check_not_negative
from .._known import limits, moments
from ..spheres._radial_law import RadialLaw
from ..spheres._unit_sphere import squared_norm
from ._constraint import matrix_constraint

SQUARE = "|x|^2 is a process of Cox, Ingersoll and Ross"
SYMMETRY = "invariance under rotations of rows and of columns"


@on_request
def stiefel(
    eps: float = 0.25, d: int = 3, p: int = 2, damping: float = 0.0, horizon: float = 0.5
) -> ConstrainedLangevin:
    """Langevin dynamics of d x p matrices with zeta = x^T x - Id, f = -damping x and sigma = 1, from (Id, 0).

    With q = p (p + 1)/2, Y = |X|^2 obeys dY = [d p + q - (Y - p)/eps - 2 damping Y] dt + 2 sqrt(Y) dB. In the limit
    eps = 0, where the damping has no effect, E X_t = exp(-(t/2) (d - 1 - (p - 1)/2)) X_0.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    d : int
        Number of rows, at least 2.
    p : int
        Number of columns, from 1, the sphere, to d, the orthogonal group.
    damping : float
        Damping rate, unit 1/time, not negative.
    horizon : float
        Final time, in the unit in which the noise has strength 1.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), on the constraint of section 4.2.
    """
    check_not_negative(eps=eps, damping=damping)
    if not (1 <= p <= d and d >= 2):
        raise ParameterError(f"p must be between 1 and d, and d at least 2, got p = {p!r} and d = {d!r}")
    # In units of |X|^2 = p: noise of strength p^{-1/2}, and the dimension for which Y has its drift.
    law = RadialLaw(eps, d * p + p * (p + 1) // 2 - 1, 1.0 / float(np.sqrt(p)), damping)
    rate = 0.5 * (d - 1.0 - 0.5 * (p - 1.0))
    decay = moments({"x_11": lambda t: float(np.exp(-rate * t))}, "linear functions are eigenfunctions")
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: stiefel(other, d, p, damping, horizon),
        drift=lambda x: -damping * x,
        strength=1.0,
        **matrix_constraint(d, p),
        horizon=horizon,
        controls=controls.ADDITIVE if eps else controls.GENERAL,
        observables=ENTRIES | SQUARES if eps else ENTRIES,
        truths=(*limits({"x_11": 0.0, "x_11^2": law.level / d}, SYMMETRY), *(radial(law, p) if eps else decay)),
        relaxation_time=law.level / rate,
        units="columns of length 1, time so that the noise has strength 1",
        source="Laurent 2022, (1.2) and (1.4), on orthonormal frames",
    )


ENTRIES: dict[str, Callable[[float, Parts], Array]] = {
    "x_11": lambda t, s: s["x"][0],
    "x_11^2": lambda t, s: s["x"][0] ** 2,
}
SQUARES: dict[str, Callable[[float, Parts], Array]] = {
    "|x|^2": lambda t, s: squared_norm(s["x"]),
    "|x|^4": lambda t, s: squared_norm(s["x"]) ** 2,
}


def radial(law: RadialLaw, p: int) -> tuple[Truth, ...]:
    """Return the moments of |x|^2, p times the process of the law, and their finite limits."""
    powers = {"|x|^2": lambda t: p * law.square(t), "|x|^4": lambda t: p**2 * law.fourth(t)}
    ends = {name: value(np.inf) for name, value in powers.items()}
    return (*moments(powers, SQUARE), *limits({name: end for name, end in ends.items() if np.isfinite(end)}, SQUARE))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [stiefel]
