"""Langevin dynamics near or on the torus, with a drift to the inner end of its tube."""

from collections.abc import Callable, Mapping

import numpy as np

from sdaeverify import Array, ConstrainedLangevin, Parts

from .. import _controls as controls
from .._arguments import check_not_negative
from .._known import limits
from ..spheres._unit_sphere import squared_norm
from ._geometry import Quartic, Tube, surface_chart
from ._law import CENTRE, check_drift, surface_means

SURFACE = "density exp(-V) on the surface, quadrature converged to rounding"


def torus_problem(
    zeta: Quartic | Tube,
    eps: float,
    stiffness: float,
    horizon: float,
    penalised: tuple[Callable[[], Mapping[str, float]], str],
    family: Callable[[float], ConstrainedLangevin],
) -> ConstrainedLangevin:
    """Return the dynamics with f = -stiffness (x - (R - r, 0, 0)) and sigma = sqrt(2), from (R - r, 0, 0).

    Parameters
    ----------
    zeta : Quartic or Tube
    eps, stiffness, horizon : float
    penalised : tuple of callable and str
        Function without arguments that returns the invariant means known for eps > 0, by observable; and their
        source.
    family : callable, eps -> ConstrainedLangevin
    """
    check_not_negative(eps=eps)
    check_drift(stiffness)
    observed = observables(zeta, limit=eps == 0.0)
    means, source = (penalised[0](), penalised[1]) if eps else (surface_means(stiffness), SURFACE)
    start = np.array([CENTRE, 0.0, 0.0])
    return ConstrainedLangevin(
        eps=eps,
        family=family,
        drift=lambda x: -stiffness * (x - start[:, None]),
        strength=float(np.sqrt(2.0)),
        constraint=zeta.zeta,
        jacobian=zeta.jacobian,
        second=zeta.second,
        laplacians=zeta.laplacians,
        start=start,
        horizon=horizon,
        controls=controls.ADDITIVE if eps else controls.GENERAL,
        observables=observed,
        truths=limits({name: means[name] for name in observed if name in means}, source),
        chart=None if eps else surface_chart(),
        relaxation_time=1.0 / stiffness if means else np.inf,
        units="radius of the tube 1, time so that the noise has strength sqrt(2)",
        source="Laurent 2022, section 4.1",
    )


def observables(zeta: Quartic | Tube, *, limit: bool) -> dict[str, Callable[[float, Parts], Array]]:
    """Return |x|^2 and x_1, and unless `limit` is true zeta and zeta^2, which vanish on the surface."""
    kept = {"|x|^2": lambda t, s: squared_norm(s["x"]), "x_1": lambda t, s: s["x"][0]}
    created = {"zeta": lambda t, s: zeta.zeta(s["x"])[0], "zeta^2": lambda t, s: zeta.zeta(s["x"])[0] ** 2}
    return kept if limit else kept | created
