"""Langevin dynamics near or on the unit sphere of R^d."""

import numpy as np

from sdaeverify import Array, ConstrainedLangevin, ParameterError, hookimpl, on_request

from .. import _controls as controls
from .._arguments import check_least, check_not_negative
from ._radial_law import RadialLaw
from ._truths import PULLED, SOURCE, free, polar_chart, truths, with_pull
from ._unit_sphere import squared_norm

ANGLE = 0.9


@on_request
def penalised_sphere(
    eps: float = 0.05,
    d: int = 2,
    pull: float = 1.0,
    damping: float = 0.0,
    spin: float = 0.0,
    horizon: float = 0.1,
) -> ConstrainedLangevin:
    """Langevin dynamics with zeta = (|x|^2 - 1)/2, f = pull e_1 - damping x + spin (-x_2, x_1, 0, ...), sigma = 1.

    Without pull, |X|^2 is a process of Cox, Ingersoll and Ross; with pull alone, the invariant law is von Mises and
    Fisher's, or for eps > 0 its counterpart around the sphere. grad ln det G = 2 x/|x|^2 and the quadratic term of
    the uniformly accurate integrator are multiples of x = g, so that the multiplier compensates errors in them.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    d : int
        Number of components, at least 2.
    pull : float
        Constant drift, unit length/time.
    damping : float
        Damping rate, unit 1/time, not negative; damping and spin must be 0 unless the pull is 0.
    spin : float
        Angular velocity, radian/time.
    horizon : float
        Final time, in the unit in which the noise has strength 1; the radius is 1.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), on the sphere.
    """
    check_parameters(eps, d, pull, damping, spin)
    law = RadialLaw(eps, d, 1.0, damping)
    known = with_pull(law, ANGLE, pull) if pull else free(law, ANGLE, spin)
    source = PULLED if pull else SOURCE
    square = known["|x|^2"].limit if eps else 1.0
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: penalised_sphere(other, d, pull, damping, spin, horizon),
        drift=lambda x: pull * np.eye(d)[:, :1] - damping * x + spin * quarter_turn(x),
        strength=1.0,
        constraint=lambda x: 0.5 * (squared_norm(x) - 1.0)[None],
        jacobian=lambda x: x[None],
        hessians=np.eye(d)[None],
        start=np.array([np.cos(ANGLE), np.sin(ANGLE), *np.zeros(d - 2)]),
        horizon=horizon,
        controls=(controls.STATIONARY_PAIR if d == 2 else controls.ADDITIVE) if eps else controls.GENERAL,
        observables={name: lambda t, s, of=each.value: of(s["x"]) for name, each in known.items()},
        truths=truths(known, source),
        chart=polar_chart(law, square) if d == 2 else None,
        relaxation_time=law.relaxation,
        units="radius 1, time so that the noise has strength 1",
        source="Laurent 2022, (1.2) and (1.4), on the sphere",
    )


def quarter_turn(x: Array) -> Array:
    """Return (-x_2, x_1, 0, ...), shape (d, P)."""
    return np.concatenate([-x[1:2], x[:1], 0.0 * x[2:]])


def check_parameters(eps: float, d: int, pull: float, damping: float, spin: float) -> None:
    """Check that the sphere exists and that closed forms are known for the parameters.

    Parameters
    ----------
    eps : float
        Stiffness parameter.
    d : int
        Dimension of the embedding space.
    pull : float
        Strength of a constant force.
    damping, spin : float
        Rates of the drift to the centre and of the rotation, unit 1/time.
    """
    check_not_negative(eps=eps, damping=damping)
    check_least(2, d=d)
    if pull and (damping or spin):
        raise ParameterError("no closed form is known with pull and damping or spin: leave one of them 0")


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [penalised_sphere]
