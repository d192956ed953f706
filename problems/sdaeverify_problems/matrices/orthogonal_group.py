"""The orthogonal group of Laurent (2022), section 4.2: matrices near or on x^T x = Id with drift to the identity."""

from collections.abc import Callable

import numpy as np

from sdaeverify import Angle, Array, Chart, ConstrainedLangevin, ParameterError, Parts, hookimpl, on_request

from .. import _controls as controls
from .._arguments import check_not_negative, check_positive
from ._constraint import matrix_constraint
from ._orthogonal_truths import SIGMA, truths


@on_request
def orthogonal_group(
    eps: float = 0.25, m: int = 2, stiffness: float = 2.0, horizon: float = 0.5
) -> ConstrainedLangevin:
    """Langevin dynamics of m x m matrices with zeta = x^T x - Id, f = -stiffness (x - Id), sigma = sqrt(2), from Id.

    grad ln det G and the quadratic term of the uniformly accurate integrator are in the range of g, so that the
    multiplier compensates errors in them. The sign of det x does not change.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    m : int
        Number of rows and columns, at least 2. For eps > 0, E tr x is known for 2 and 3, and for 4 and 5 with
        stiffness 100 and four values of eps.
    stiffness : float
        Stiffness of the drift, unit 1/time, positive, at most 1e4; 100 in section 4.2.
    horizon : float
        Final time.

    Source
    ------
    Laurent (2022), section 4.2 and (4.1).
    """
    check_not_negative(eps=eps)
    check_positive(stiffness=stiffness)
    if m < 2:
        raise ParameterError(f"m must be at least 2, got {m!r}: the orthogonal group of 1 x 1 matrices is two points")
    if stiffness > 1e4:
        raise ParameterError(f"stiffness must be at most 1e4, got {stiffness!r}")
    identity = np.eye(m).reshape(-1, 1)
    known = truths(eps, m, stiffness)
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: orthogonal_group(other, m, stiffness, horizon),
        drift=lambda x: -stiffness * (x - identity),
        strength=SIGMA,
        **matrix_constraint(m, m),
        horizon=horizon,
        controls=controls.ADDITIVE if eps else controls.GENERAL,
        observables=OBSERVABLES if eps else {"tr x": OBSERVABLES["tr x"]},
        truths=known,
        chart=rotations() if m == 2 and eps == 0.0 else None,
        relaxation_time=1.0 / max(stiffness, SIGMA**2 * (m - 1) / 4.0) if known else np.inf,
        units="entries of the identity 1, time so that the noise has strength sqrt(2)",
        source="Laurent 2022, section 4.2",
    )


def trace(x: Array) -> Array:
    """Return tr x, shape (P,)."""
    m = int(np.sqrt(len(x)))
    return np.asarray(x[:: m + 1].sum(axis=0))


OBSERVABLES: dict[str, Callable[[float, Parts], Array]] = {
    "tr x": lambda t, s: trace(s["x"]),
    "|x|^2": lambda t, s: (s["x"] ** 2).sum(axis=0),
}


def rotations() -> Chart:
    """Return the chart of rotations of the plane, with the angle as coordinate."""
    return Chart(
        axes=(Angle(),),
        embed=lambda z: np.concatenate([np.cos(z), -np.sin(z), np.sin(z), np.cos(z)]),
        read=lambda x: np.arctan2(x[2:3] - x[1:2], x[:1] + x[3:]),
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [orthogonal_group]
