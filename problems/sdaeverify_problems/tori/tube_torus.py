"""The torus with a constraint function whose gradient has constant length on level sets, for a known density."""

from sdaeverify import ConstrainedLangevin, hookimpl, on_request

from ._geometry import Tube
from ._law import tube_means
from ._problem import torus_problem

SOURCE = "density exp(-V) s^(1 + r^2/(2 eps)) exp(-s^2/(4 eps)), quadrature converged to rounding"


@on_request
def tube_torus(eps: float = 0.1, stiffness: float = 25.0, horizon: float = 0.125) -> ConstrainedLangevin:
    """Langevin dynamics with zeta = (s^2 - r^2)/2, s the distance from the core circle, R = 3 and r = 1.

    f = -stiffness (x - (R - r, 0, 0)) = -grad V and sigma = sqrt(2), from (R - r, 0, 0). In the limit the dynamics
    are those of `torus`, but for eps > 0 they differ, because g G^{-1} zeta = grad (s^2/4 - (r^2/2) ln s) and
    det G = s^2, so that the invariant density is exp(-V) s^{1 + r^2/(2 eps)} exp(-s^2/(4 eps)).

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    stiffness : float
        Stiffness of the potential, unit 1/time, from 16 to 2500.
    horizon : float
        Final time.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), with the surface and the drift of section 4.1.
    """
    return torus_problem(
        Tube(),
        eps,
        stiffness,
        horizon,
        (lambda: tube_means(stiffness, eps), SOURCE),
        lambda other: tube_torus(other, stiffness, horizon),
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [tube_torus]
