"""Langevin dynamics without drift near or on closed curves: an ellipse in the plane, and a curve in space."""

from functools import partial

import numpy as np

from sdaeverify import Angle, Chart, ConstrainedLangevin, Truth, hookimpl, on_request

from .. import _controls as controls
from .._arguments import check_choice, check_not_negative, check_positive
from .._known import limits, moments, monomials
from ._closed_curve import ClosedCurve
from ._curve_shapes import SHAPES

SOURCE = "Brownian motion by arc length, Fourier series"


OBSERVABLES = monomials("x_1", "x_2", "x_1^2", "x_1 x_2")


@on_request
def constrained_curve(
    eps: float = 0.0, shape: str = "ellipse", sigma: float = 0.8, theta_0: float = 1.0, horizon: float = 1.0
) -> ConstrainedLangevin:
    """Langevin dynamics without drift, in the limit a Brownian motion by arc length, of variance sigma^2 t.

    ellipse:  zeta = (x_1^2/4 + x_2^2 - 1)/2,                     x = (2 cos theta, sin theta);
    space:    zeta = ((x_1^2 + x_2^2 - 1)/2, x_3 - 0.7 x_1 x_2),  x = (cos theta, sin theta, 0.35 sin 2 theta).

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time; exact expectations exist only for 0.
    shape : str
        ``ellipse`` or ``space``.
    sigma : float
        Noise amplitude, unit length/sqrt(time), positive.
    theta_0 : float
        Initial angle, radian.
    horizon : float
        Final time.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), on curves of codimension one and two.
    """
    check_not_negative(eps=eps)
    check_positive(sigma=sigma)
    check_choice("shape", shape, SHAPES)
    radius, gamma, zeta = SHAPES[shape]
    curve = ClosedCurve(gamma, sigma)
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: constrained_curve(other, shape, sigma, theta_0, horizon),
        drift=lambda x: 0.0 * x,
        strength=sigma,
        **zeta.fields(),
        start=gamma(np.array([[theta_0]]))[:, 0],
        horizon=horizon,
        controls=controls.ADDITIVE if eps else controls.GENERAL,
        observables=OBSERVABLES,
        truths=() if eps else truths(curve, theta_0),
        chart=None if eps else Chart((Angle(),), gamma, lambda x: np.arctan2(x[1], x[0] / radius)[None]),
        relaxation_time=np.inf if eps else curve.relaxation,
        units="small half axis 1, time in the unit in which sigma is given",
        source="Laurent 2022, (1.2) and (1.4), on a closed curve",
    )


def truths(curve: ClosedCurve, theta_0: float) -> tuple[Truth, ...]:
    """Return the expectations of all observables at every time and under the invariant law."""
    values = {name: lambda x, of=of: of(0.0, {"x": x}) for name, of in OBSERVABLES.items()}
    at_times = {name: partial(curve.expectation, phi, theta_0) for name, phi in values.items()}
    return (*moments(at_times, SOURCE), *limits({name: curve.mean(phi) for name, phi in values.items()}, SOURCE))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [constrained_curve]
