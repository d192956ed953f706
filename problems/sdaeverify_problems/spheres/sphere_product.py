"""Independent points near or on unit spheres, with mixed constraints."""

import numpy as np

from sdaeverify import Array, ConstrainedLangevin, ParameterError, hookimpl, on_request

from .. import _controls as controls
from .._arguments import check_least, check_not_negative
from .._known import moments
from .._quadrics import Quadrics
from ._radial_law import RadialLaw
from ._truths import SOURCE, Known, free

ANGLES = 0.9, 2.0


@on_request
def sphere_product(
    eps: float = 0.25, d: int = 2, spheres: int = 2, mixing: float = 0.4, horizon: float = 0.5
) -> ConstrainedLangevin:
    """Langevin dynamics of x = (y_1, ..., y_q), y_i in R^d, with zeta = A ((|y_i|^2 - 1)/2)_i, f = 0 and sigma = 1.

    A = Id + mixing C with a fixed matrix C. Neither (1.2) nor (1.4) depends on a regular A: the y_i are independent
    solutions of single-sphere problems, so that products of functions of different y_i have known expectations.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    d : int
        Number of components of each point, at least 2.
    spheres : int
        Number q of points, at least 2.
    mixing : float
        Strength of the mixing, 0 for separate constraints; A must be regular.
    horizon : float
        Final time, in the unit in which the noise has strength 1; the radius is 1.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), on products of spheres.
    """
    check_not_negative(eps=eps)
    check_least(2, d=d, spheres=spheres)
    A = mixture(spheres, mixing)
    law = RadialLaw(eps, d, 1.0)
    known = point_truths(law)
    angles = np.resize(ANGLES, spheres)
    starts = np.stack([np.cos(angles), np.sin(angles), *np.zeros((d - 2, spheres))], axis=1)
    blocks = np.eye(d * spheres).reshape(spheres, d, -1)
    zeta = Quadrics(
        np.einsum("ki,ian,iam->knm", A, blocks, blocks), np.zeros((spheres, d * spheres)), -0.5 * A.sum(axis=1)
    )
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: sphere_product(other, d, spheres, mixing, horizon),
        drift=lambda x: 0.0 * x,
        strength=1.0,
        **zeta.fields(),
        start=starts.ravel(),
        horizon=horizon,
        controls=controls.ADDITIVE if eps else controls.GENERAL,
        observables={name: lambda t, s, of=each.value: of(s["x"]) for name, each in known.items()},
        truths=moments({name: each.moment for name, each in known.items()}, SOURCE),
        units="radii 1, time so that the noise has strength 1",
        source="Laurent 2022, (1.2) and (1.4), on products of spheres",
    )


def mixture(q: int, mixing: float) -> Array:
    """Return A, shape (q, q); raise if its condition number is not below 1e3."""
    i, j = np.indices((q, q))
    A = np.eye(q) + mixing * np.sin(1.0 + i + 3.0 * j)
    if not (np.isfinite(mixing) and np.linalg.cond(A) < 1e3):
        raise ParameterError(f"A must be regular, which it is hardly or not for mixing = {mixing!r}")
    return np.asarray(A)


def point_truths(law: RadialLaw) -> dict[str, Known]:
    """Return the known observables of the first two points, and their products, whose factors are independent."""
    one, two = (free(law, angle) for angle in ANGLES)
    known = {}
    for name in one.keys() - {"|x|^4"}:
        known[name.replace("x", "y1")] = first = at_block(0, law.d, one[name])
        known[name.replace("x", "y2")] = second = at_block(1, law.d, two[name])
        known[f"{name} of y1 times {name} of y2"] = product(first, second)
    return {name: known[name] for name in sorted(known)}


def at_block(i: int, d: int, known: Known) -> Known:
    """Return an observable of one point as an observable of the i-th point.

    Parameters
    ----------
    i : int
        Index of the point, from 0.
    d : int
        Number of coordinates of each point.
    known : Known
        Observable of a single point.
    """
    return known._replace(value=lambda x: known.value(x[i * d : (i + 1) * d]))


def product(first: Known, second: Known) -> Known:
    """Return the product of two independent observables, with the products of their expectations."""
    (value, moment, limit), (other, further, last) = first, second
    return Known(lambda x: value(x) * other(x), lambda t: moment(t) * further(t), limit * last)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [sphere_product]
