"""What is known of dynamics near or on the unit sphere, by observable."""

from collections.abc import Callable, Mapping
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
    """An observable of a point near the sphere, its expectation at every time if known, and its invariant mean.

    Attributes
    ----------
    value : callable, ndarray of shape (d, P) -> ndarray of shape (P,)
    moment : callable, t -> float, or None
    limit : float
    """

    value: Callable[[Array], Array]
    moment: Callable[[float], float] | None
    limit: float


def free(law: RadialLaw, angle: float, spin: float = 0.0) -> Mapping[str, Known]:
    """Return what is known without pull, from (cos angle, sin angle, 0, ...) turning at a rate in its plane."""

    def first(t: float) -> float:
        return law.harmonic(1, t) * float(np.cos(angle + spin * t))

    def square(t: float) -> float:
        return law.square(t) / law.d + law.harmonic(2, t) * float(np.cos(angle + spin * t) ** 2 - 1.0 / law.d)

    known = {
        "x_1": Known(lambda x: x[0], first, 0.0),
        "x_1^2": Known(lambda x: x[0] ** 2, square, law.level / law.d),
    }
    radial = {
        "|x|^2": Known(squared_norm, law.square, law.square()),
        "|x|^4": Known(lambda x: squared_norm(x) ** 2, law.fourth, law.fourth()),
    }
    return known | (radial if law.eps else {})


def with_pull(law: RadialLaw, angle: float, pull: float) -> Mapping[str, Known]:
    """Return what is known with the drift pull e_1 alone: moments at every time in the limit only."""
    means, u = invariant_means(law.eps, law.d, law.sigma, pull), float(np.cos(angle))
    limit = None if law.eps else on_the_sphere(law.d, law.sigma, pull)

    def power(n: int) -> Callable[[float], float] | None:
        return None if limit is None else lambda t: limit.expectation(lambda c: c**n, u, t)

    known = {
        "x_1": Known(lambda x: x[0], power(1), means["x_1"]),
        "x_1^2": Known(lambda x: x[0] ** 2, power(2), means["x_1^2"]),
    }
    radial = {
        "|x|^2": Known(squared_norm, None, means["|x|^2"]),
        "|x|^4": Known(lambda x: squared_norm(x) ** 2, None, means["|x|^4"]),
    }
    return known | (radial if law.eps else {})


def truths(known: Mapping[str, Known], source: str) -> tuple[Truth, ...]:
    """Return the expectations that are known at every time, and the invariant means, but those that overflow."""
    values = {name: each.moment for name, each in known.items() if each.moment is not None}
    means = {name: each.limit for name, each in known.items() if np.isfinite(each.limit)}
    return (*moments(values, source), *limits(means, source))


def polar_chart(law: RadialLaw, square: float) -> Chart | None:
    """Return the angle and log |x| in the plane, the angle alone on the circle, for E |x|^2 in the long run.

    There is none where E |x|^2 is not known.
    Var |x|^2 = (2 sigma^2/b) E |x|^2 without pull, and log |x| varies by half of |x|^2/E |x|^2.
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
