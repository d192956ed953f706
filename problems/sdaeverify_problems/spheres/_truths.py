"""Known moments and invariant means of dynamics near or on the unit sphere, by observable."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from sdaeverify import Angle, Array, Chart, Line, Truth

from .._known import limits, moments
from ..curves._circle import direction
from ._pulled_law import invariant_means, on_the_sphere
from ._radial_law import RadialLaw
from ._unit_sphere import squared_norm

SOURCE = "harmonic polynomials of a process of Cox, Ingersoll and Ross"
PULLED = "von Mises and Fisher's law, or its mixture around the sphere"


class Known(NamedTuple):
    """An observable of a point near the sphere, with its moment, None if unknown, and its invariant mean.

    Attributes
    ----------
    value : callable, ndarray of shape (d, P) -> ndarray of shape (P,)
    moment : callable, t -> float, or None
    limit : float
    """

    value: Callable[[Array], Array]
    moment: Callable[[float], float] | None
    limit: float


Moment = Callable[[float], float]
VALUES: dict[str, Callable[[Array], Array]] = {
    "x_1": lambda x: x[0],
    "x_1^2": lambda x: x[0] ** 2,
    "|x|^2": squared_norm,
    "|x|^4": lambda x: squared_norm(x) ** 2,
}


def _known(
    eps: float, moments: Sequence[Callable[[float], float] | None], means: Iterable[float]
) -> dict[str, Known]:
    # On the sphere |x| is 1, so that powers of |x| are omitted.
    found = {name: Known(*each) for name, *each in zip(VALUES, VALUES.values(), moments, means, strict=True)}
    return {name: each for name, each in found.items() if eps or "|" not in name}


def free(law: RadialLaw, angle: float, spin: float = 0.0) -> Mapping[str, Known]:
    """Return the known observables without pull, for the start (cos angle, sin angle, 0, ...).

    `spin` is the rate of the rotation in the plane of the first two components.
    """

    def first(t: float) -> float:
        return law.harmonic(1, t) * float(np.cos(angle + spin * t))

    def square(t: float) -> float:
        return law.square(t) / law.d + law.harmonic(2, t) * float(np.cos(angle + spin * t) ** 2 - 1.0 / law.d)

    limits = (0.0, law.level / law.d, law.square(), law.fourth())
    return _known(law.eps, (first, square, law.square, law.fourth), limits)


def with_pull(law: RadialLaw, angle: float, pull: float) -> Mapping[str, Known]:
    """Return the known observables with the drift pull e_1 alone; moments are known only for eps = 0."""
    means, u = invariant_means(law.eps, law.d, law.sigma, pull), float(np.cos(angle))
    if law.eps:
        return _known(law.eps, [None] * len(VALUES), means.values())
    limit = on_the_sphere(law.d, law.sigma, pull)
    powers = (lambda t, n=n: limit.expectation(lambda c: c**n, u, t) for n in (1, 2))
    return _known(law.eps, (*powers, None, None), means.values())


def truths(known: Mapping[str, Known], source: str) -> tuple[Truth, ...]:
    """Return the known moments, and the invariant means that are finite."""
    values = {name: each.moment for name, each in known.items() if each.moment is not None}
    means = {name: each.limit for name, each in known.items() if np.isfinite(each.limit)}
    return (*moments(values, source), *limits(means, source))


def polar_chart(law: RadialLaw, square: float) -> Chart | None:
    """Return the angle and log |x| as coordinates in the plane, or the angle on the circle.

    `square` is the invariant mean of |x|^2; the result is None if it is not finite. Without pull,
    Var |x|^2 = (2 sigma^2/b) E |x|^2, and the deviation of log |x| is half of that of |x|^2/E |x|^2.
    """
    if law.eps == 0.0:
        return Chart(axes=(Angle(),), embed=direction, read=lambda x: np.arctan2(x[1], x[0])[None])
    if not np.isfinite(square):
        return None
    line = Line(0.5 * float(np.log(square)), law.sigma / float(np.sqrt(2.0 * law.rate * square)))
    return Chart(
        axes=(Angle(), line),
        embed=lambda z: np.exp(z[1]) * direction(z[:1]),
        read=lambda x: np.stack([np.arctan2(x[1], x[0]), 0.5 * np.log(squared_norm(x))]),
    )
